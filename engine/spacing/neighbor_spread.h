// How a point and its nearest neighbours lie about their mean.
#pragma once

#include <span>

#include "engine/geometry/point_tree.h"
#include "engine/geometry/symmetric_eigen.h"
#include "io/vec3.h"

namespace orbweave {

/// The sum of their products about the mean. `nearest`: of `points`, not empty.
inline SymmetricMatrix spread_of(std::span<const Vec3> points, std::span<const Neighbor> nearest) {
  const Vec3 origin = points[nearest.front().index];
  Vec3 center;
  for (const Neighbor& n : nearest) center = center + (points[n.index] - origin);
  center = center / static_cast<double>(nearest.size());
  SymmetricMatrix spread;
  for (const Neighbor& n : nearest) spread += outer(points[n.index] - origin - center);
  return spread;
}

}  // namespace orbweave
