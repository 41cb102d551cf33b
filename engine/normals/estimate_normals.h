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
  /// Neighbours farther away do not count; world units. Also the halo that a chunk needs.
  double max_radius = 0.0;
  const StopToken* stop = nullptr;  ///< looked at every few thousand points; may be null
};

struct EstimatedNormals {
  /// Unit normals of the points asked for, of either sign (the same for any partition); zero where
  /// there is none: fewer than three neighbours within the radius, or all of them on one line.
  std::vector<Vec3> normals;
  /// Deviation of the neighbours from the plane over their deviation in it: 0 a plane, 1 no plane
  /// at all.
  std::vector<float> roughness;
};

/// Normals of positions [begin, end). Positions must be distinct, finite and in canonical order,
/// and hold everything within max_radius of the points asked for; the result then does not depend,
/// to the last bit, on what else they hold. Neighbours are summed in canonical order. A
/// neighbourhood that is nearly a line (a single scan row) is doubled, up to 16 times within the
/// radius, until it is none. Runs on the calling TBB arena. O(n log n).
EstimatedNormals estimate_normals(std::span<const Vec3> positions, std::uint32_t begin,
                                  std::uint32_t end, const NormalEstimateOptions& options);

}  // namespace orbweave
