// What the orientation of the whole cloud knows of its patches.
#pragma once

#include <cstdint>

#include "io/vec3.h"

namespace orbweave {

/// Chunks of points do not know each other's numbers but for these: `global` of the first point of
/// the patch in canonical order.
using PatchId = std::uint64_t;

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
  double area = 0.0;     ///< of its points, whatever way their normals point; 0: not known
};

/// The middle of the bounds.
inline Vec3 center_of(const PatchSum& sum) { return sum.lowest + 0.5 * (sum.highest - sum.lowest); }

/// How nearly the normals of a patch are one: 1 on a plane, well below on leaves and noise.
inline double coherence(const PatchSum& sum) {
  return sum.area > 0.0 ? norm(sum.area_normal) / sum.area : 1.0;
}

/// The area of a patch that is a surface; 0 for one that is leaves or noise, whose side means
/// little.
inline double surface_area(const PatchSum& sum) {
  constexpr double kCoherent = 0.75;
  return coherence(sum) < kCoherent ? 0.0 : norm(sum.area_normal);
}

}  // namespace orbweave
