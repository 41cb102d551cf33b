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

#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

/// Chunks of points do not know each other's numbers but for these: `global` of the first point of
/// the patch in canonical order.
using PatchId = std::uint64_t;

struct OrientationOptions {
  double cell = 0.0;                ///< side of a lattice cell, a power of two, world units
  std::size_t neighbors = 10;       ///< of a point that vote
  double max_radius = 0.0;          ///< neighbours farther away do not vote; world units
  const StopToken* stop = nullptr;  ///< looked at every few thousand points; may be null
};

/// Votes of one patch's points on how another patch's normals relate to its own.
struct PatchVote {
  PatchId from = 0;
  PatchId to = 0;
  double votes = 0.0;   ///< sum of signed votes: > 0 agree, < 0 one of them is to be turned
  double weight = 0.0;  ///< sum of their sizes; |votes| / weight tells how sure they are
};

/// What the whole cloud's orientation needs of a patch.
struct PatchSum {
  PatchId patch = 0;
  std::uint64_t points = 0;
  Vec3 lowest, highest;  ///< bounds
  Vec3 area_normal;      ///< sum of a point's normal times its area, as oriented in the patch
  double flux = 0.0;     ///< sum of area * normal . (position - a corner of the patch's cell)
  Vec3 flux_origin;      ///< that corner
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

struct PatchOrientation {
  std::vector<PatchId> patches;    ///< ascending
  std::vector<std::uint8_t> turn;  ///< 1: all normals of the patch are turned
  std::uint64_t components = 0;    ///< parts of the cloud that no vote connects
  std::uint64_t contested = 0;     ///< patches whose votes for the sign they got are not 3 to 1
  double satisfied = 1.0;          ///< share of the votes' weight that the result satisfies
};

/// One sign per patch: pairs of patches are joined in the order of how strong their votes are, the
/// votes of joined patches add up, and every component ends outward (positive enclosed volume; a
/// sheet that encloses nothing, upward).
/// The result does not depend on the order of the arguments' rows. O(n log n); holds all patches.
PatchOrientation orient_patch_graph(std::vector<PatchSum> sums, std::vector<PatchVote> votes,
                                    const StopToken* stop = nullptr);

/// Which of some points' normals are turned in the end: `turn` within their patches (see
/// OrientedPatches), and by the sign of their patch in the whole cloud.
std::vector<std::uint8_t> whole_turns(std::span<const PatchId> patch_of,
                                      std::vector<std::uint8_t> turn,
                                      const PatchOrientation& orientation);

}  // namespace orbweave
