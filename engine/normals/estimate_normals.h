// Normals of points that have none: the plane of the nearest neighbours.
// Hoppe, DeRose, Duchamp, McDonald, Stuetzle: Surface Reconstruction from Unorganized Points, 1992,
// section 3.1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

struct NormalEstimateOptions {
  std::size_t neighbors = 16;  ///< the point itself not counted, at least 3
  /// Neighbours farther away do not count; world units.
  double max_radius = 0.0;
  const StopToken* stop = nullptr;  ///< looked at every few thousand points; may be null
  /// Positive: the points of a cube of a lattice with that side have the normal of the one that is
  /// nearest to their middle (where it has none, their own). Others have their own.
  double shared_side = 0.0;
};

struct EstimatedNormals {
  /// Unit normals of the points asked for, of either sign (the same for any partition); zero where
  /// there is none: fewer than three neighbours within the radius, or all of them on one line.
  std::vector<Vec3> normals;
  /// Deviation of the neighbours from the plane over their deviation in it: 0 a plane, 1 no plane
  /// at all.
  std::vector<float> roughness;
};

/// Margin that a chunk needs around its points.
double normal_halo(const NormalEstimateOptions& options);

/// Normals of positions [begin, end). Positions must be distinct, finite and in canonical order,
/// and reach as far as the halo; the result then does not depend, to the last bit, on what else
/// they hold. Neighbours are summed in canonical order. A
/// neighbourhood that is nearly a line (a single scan row) is doubled, up to 16 times within the
/// radius, until it is none. Points of [begin, end) whose flag in `chosen` is 0 have no normal;
/// empty: all are chosen. Runs on the calling TBB arena. O(n log n).
EstimatedNormals estimate_normals(std::span<const Vec3> positions, std::uint32_t begin,
                                  std::uint32_t end, const NormalEstimateOptions& options,
                                  std::span<const std::uint8_t> chosen = {});

}  // namespace orbweave
