// The walk at one point: all triangles with an empty ball that have the point as a vertex.
// docs/dev/ball-pivoting.md gives the geometry; the code is in walk_kernel.inl, once per vector
// width.
#pragma once

#include <cstdint>

#include "engine/geometry/vector_width.h"
#include "io/vec3.h"

namespace orbweave {

/// Arrays behind which this many further elements may be read (and are ignored).
inline constexpr std::uint32_t kLanePadding = 8;

/// Points sorted by cell; parallel arrays, coordinates relative to a common origin, padded.
struct PointArrays {
  const double* x = nullptr;
  const double* y = nullptr;
  const double* z = nullptr;
  const Vec3* normals = nullptr;  ///< any length but zero
};

/// Where the points within two ball radii are to be looked for: ranges of the arrays.
struct CandidateRanges {
  static constexpr int kMost = 9;
  std::uint32_t begin[kMost] = {};
  std::uint32_t end[kMost] = {};
  int count = 0;
  std::uint32_t size() const {
    std::uint32_t total = 0;
    for (int r = 0; r < count; ++r) total += end[r] - begin[r];
    return total;
  }
};

/// All points in groups of eight that lie close together, groups of such groups, and so on. Behind
/// the last entry of a level there are, up to a multiple of eight, some that are out of reach.
struct GroupedPoints {
  static constexpr int kMostLevels = 12;
  static constexpr std::uint32_t kGroup = 8;
  struct Level {
    const double* x = nullptr;  ///< points, or the centres of spheres that hold a group of points
    const double* y = nullptr;
    const double* z = nullptr;
    const double* radius = nullptr;  ///< of the spheres; 0 for points
    std::uint32_t count = 0;
  };
  Level level[kMostLevels];  ///< entry k of a level holds 8k to 8k + 7 of the one before
  int levels = 0;
  const std::uint32_t* id = nullptr;     ///< of the entries of the first level, in PointArrays
  const std::uint32_t* place = nullptr;  ///< of each point of PointArrays, in the first level
};

/// The neighbours of a point, with room for every candidate plus kLanePadding.
struct Neighbours {
  double* dx = nullptr;  ///< neighbour minus point, in ball radii
  double* dy = nullptr;
  double* dz = nullptr;
  double* cap_height = nullptr;  ///< |d|^2 / 2: the ball contains the neighbour when u.d exceeds it
  double* inverse_length = nullptr;
  std::uint32_t* id = nullptr;  ///< index into PointArrays
};

/// Working arrays of one walk.
struct WalkScratch {
  std::uint32_t point = 0;  ///< index into PointArrays
  std::uint32_t count = 0;  ///< of its neighbours
  Neighbours neighbours;
  std::uint32_t* list = nullptr;  ///< some of the neighbours
  double* arc_begin = nullptr;    ///< covered arcs of a circle, as pseudo-angles in [0, 4)
  double* arc_length = nullptr;
};

/// Two neighbours i, j of a triangle (p, i, j), as i << 32 | j (indices into PointArrays).
using Corner = std::uint64_t;
constexpr Corner make_corner(std::uint32_t first, std::uint32_t second) {
  return Corner{first} << 32 | second;
}
constexpr std::uint32_t first_of(Corner c) { return static_cast<std::uint32_t>(c >> 32); }
constexpr std::uint32_t second_of(Corner c) { return static_cast<std::uint32_t>(c); }

/// The triangles at a point.
struct Fan {
  Corner* corners = nullptr;  ///< room for corner_bound(candidates)
  std::uint32_t count = 0;
  bool closed = false;  ///< one cycle of accepted triangles, no neighbour twice
  /// No ball of this radius that touches the point is empty, whatever its direction; told where all
  /// circles were looked at. An empty larger ball would hold an empty one, so none is empty either.
  bool blocked = false;
};

/// A bound on the corners at a point with this number of neighbours: every edge of its Voronoi cell
/// (at most 3k - 6) meets the sphere at most twice.
constexpr std::uint32_t corner_bound(std::uint32_t neighbours) { return 6 * neighbours + 8; }

/// Most points of one call of a walk function.
inline constexpr std::uint32_t kWalksAtOnce = 8;

/// Collects the neighbours of scratch.point, all of whom are among the candidates.
using GatherFunction = void (*)(const PointArrays& points, const CandidateRanges& candidates,
                                double ball_radius, WalkScratch& scratch);

/// Collects the neighbours of scratch.point that have a part in what is free at the point, and some
/// more, kMostOfCrowd at most: the same triangles are found as with all neighbours. Takes time for
/// these, not for all in reach. False where that fails, and nothing is collected.
inline constexpr std::uint32_t kMostOfCrowd = 2048;
using GatherCrowdFunction = bool (*)(const PointArrays& points, const GroupedPoints& groups,
                                     double ball_radius, WalkScratch& scratch);

/// Finds the triangles at `count` points, at most kWalksAtOnce, whose neighbours are gathered: if
/// the walk around a point's normal closes, its fan; otherwise all triangles of T_rho at the point.
/// Walks may go among the nearest neighbours first; that saves time or costs some, and changes
/// nothing else. Returns how many fans were settled there.
using WalkFunction = std::uint32_t (*)(const PointArrays& points, const WalkScratch* scratch,
                                       std::uint32_t count, bool nearest_first, Fan* fans);

/// Finds corners at scratch.point, whose neighbours are gathered (`active`: by index): those of all
/// triangles of T_rho whose three vertices are active, if the point's index is the smallest of
/// them, and some more. `taken`: corners of triangles that there are at the point; corners with the
/// same first or the same second neighbour may be left out.
using SuspectFunction = void (*)(const PointArrays& points, const WalkScratch& scratch,
                                 const std::uint8_t* active, const Corner* taken,
                                 std::uint32_t taken_count, Fan& fan);

/// Finds the triangles of T_rho at scratch.point, whose neighbours are gathered, on the circles of
/// some neighbours alone: those that come first in the `count` corners of `suspected`, where equal
/// ones stand side by side. Every triangle found has a neighbour from there, and all three vertices
/// are active.
using ConfirmFunction = void (*)(const PointArrays& points, const WalkScratch& scratch,
                                 const std::uint8_t* active, const Corner* suspected,
                                 std::uint32_t count, Fan& fan);

struct WalkKernel {
  GatherFunction gather = nullptr;
  GatherCrowdFunction gather_crowd = nullptr;
  WalkFunction walk = nullptr;
  SuspectFunction suspect = nullptr;
  ConfirmFunction confirm = nullptr;
};
WalkKernel walk_kernel_generic();
WalkKernel walk_kernel_avx2();
WalkKernel walk_kernel_avx512();

WalkKernel walk_kernel(VectorWidth width);

}  // namespace orbweave
