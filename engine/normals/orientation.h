// Which of its two directions a normal takes, where the position of the scanner is unknown: votes
// between neighbours, first within small patches, then between the patches of the whole cloud.
// The idea of propagation is Hoppe et al. 1992, section 3.3; the vote across an edge follows
// König, Gumhold: Consistent Propagation of Normal Orientations in Point Clouds, 2009.
//
// A patch is what a cell of a lattice holds of one sheet. The lattice is anchored at the world's
// zero and its cells are powers of two, so that patches, their votes and their sums are those of
// the uncut cloud, whatever chunk computes them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/normals/part_sides.h"
#include "engine/normals/patch_sums.h"
#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

struct OrientationOptions {
  double cell = 0.0;                ///< side of a lattice cell, a power of two, world units
  std::size_t neighbors = 10;       ///< of a point that vote
  double max_radius = 0.0;          ///< neighbours farther away do not vote; world units
  const StopToken* stop = nullptr;  ///< looked at every few thousand points; may be null
  std::size_t among = 0;            ///< nearest neighbours that the voters are chosen from, or 0
};

/// The patches of the cells that own points [begin, end).
struct OrientedPatches {
  std::vector<PatchId> patch_of;   ///< of points [begin, end)
  std::vector<std::uint8_t> turn;  ///< of the same: 1 where the normal is turned within its patch
  std::vector<PatchSum> sums;      ///< of patches whose first point is in [begin, end), by id
  std::vector<PatchVote> votes;    ///< of those patches, by (from, to)
};

/// Margin that a chunk needs around its owned points, along each axis.
double orientation_halo(const OrientationOptions& options);

/// Finite positions that reach as far as the halo, in the same order for every partition: about the
/// canonical one, for speed (points that were moved since they were sorted do little harm). They
/// need not be distinct: points at the same place do not vote on each other. Unit normals of either
/// sign, zero where there is none (such a point gets patch_of = its own number and takes no part).
/// `global`: the points' numbers in the whole cloud, ascending. Runs on the calling TBB arena.
OrientedPatches orient_patches(std::span<const Vec3> positions, std::span<const Vec3> normals,
                               std::span<const std::uint64_t> global, std::uint32_t begin,
                               std::uint32_t end, const OrientationOptions& options);

/// What decides where votes say nothing.
struct PatchGraphOptions {
  bool inward = false;        ///< closed surfaces point inward instead of outward
  bool ground = false;        ///< patches that belong to the ground vote to face up
  Vec3 up = {0.0, 0.0, 1.0};  ///< for the ground; a unit vector
  double cell = 0.0;          ///< for the ground: OrientationOptions::cell
  const StopToken* stop = nullptr;
};

/// A part of space in which patches are contested.
struct ContestedPlace {
  Vec3 center;
  std::uint64_t patches = 0;
};

/// A part of the surface whose side as a whole is a guess.
struct DoubtfulPart {
  Vec3 center;
  double area = 0.0;                   ///< share of the surface
  PartDoubt doubt = PartDoubt::kNone;  ///< kNone: joined although votes contradict each other
};

struct PatchOrientation {
  std::vector<PatchId> patches;        ///< ascending
  std::vector<std::uint8_t> turn;      ///< 1: all normals of the patch are turned
  std::uint64_t components = 0;        ///< parts that no vote connects, nor the ground
  std::uint64_t contested = 0;         ///< patches whose votes for the sign they got are not 3 to 1
  double contested_area = 0.0;         ///< share of the surface that they are
  std::vector<ContestedPlace> places;  ///< with the most of them, at most three, most first
  std::uint64_t ground = 0;            ///< patches that belong to the ground, where that is asked
  std::uint64_t ground_down = 0;       ///< of them, those that face down all the same
  double satisfied = 1.0;              ///< share of the votes' weight that the result satisfies
  std::vector<OrientedPart> parts;     ///< the components, by their smallest patch
  std::vector<WeakJoin> weak;          ///< large parts whose side within a component is a guess
  std::uint64_t interiors = 0;         ///< components that turned out to be seen from their inside
  double doubtful_area = 0.0;          ///< share of the surface whose side as a whole is a guess
  std::vector<DoubtfulPart> doubtful;  ///< the largest of them, at most three, largest first
};

/// One sign per patch: pairs of patches are joined in the order of how strong their votes are, the
/// votes of joined patches add up, and every component ends outward (positive enclosed volume; a
/// sheet that encloses nothing, upward), or as the options say. The ground's votes are those of one
/// more patch, the sky, so that they add up as the ground is joined: neither clutter that stands on
/// it nor what lies apart turns it.
/// The result does not depend on the order of the arguments' rows. O(n log n); holds all patches.
PatchOrientation orient_patch_graph(std::vector<PatchSum> sums, std::vector<PatchVote> votes,
                                    const PatchGraphOptions& options = {});

/// Which of some points' normals are turned in the end: `turn` within their patches (see
/// OrientedPatches), and by the sign of their patch in the whole cloud.
std::vector<std::uint8_t> whole_turns(std::span<const PatchId> patch_of,
                                      std::vector<std::uint8_t> turn,
                                      const PatchOrientation& orientation);

}  // namespace orbweave
