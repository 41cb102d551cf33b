// Axis-aligned boxes, world units.
#pragma once

#include <algorithm>
#include <limits>

#include "io/vec3.h"

namespace orbweave {

/// Closed axis-aligned box. Default-constructed it is empty and grows with `extend`.
struct Box {
  Vec3 min{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
           std::numeric_limits<double>::infinity()};
  Vec3 max{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
           -std::numeric_limits<double>::infinity()};

  bool empty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
  void extend(Vec3 p) {
    for (int axis = 0; axis < 3; ++axis) {
      min[axis] = std::min(min[axis], p[axis]);
      max[axis] = std::max(max[axis], p[axis]);
    }
  }
  void extend(const Box& other) {
    if (other.empty()) return;
    extend(other.min);
    extend(other.max);
  }
  bool contains(Vec3 p) const {
    return p.x >= min.x && p.x <= max.x && p.y >= min.y && p.y <= max.y && p.z >= min.z &&
           p.z <= max.z;
  }
  bool intersects(const Box& o) const {
    return min.x <= o.max.x && o.min.x <= max.x && min.y <= o.max.y && o.min.y <= max.y &&
           min.z <= o.max.z && o.min.z <= max.z;
  }
  Box grown(double margin) const {
    const Vec3 m{margin, margin, margin};
    return {min - m, max + m};
  }
  Vec3 extent() const { return empty() ? Vec3{} : max - min; }
  double largest_extent() const { return std::max({extent().x, extent().y, extent().z}); }
  /// Precondition: not empty.
  Vec3 center() const { return min + 0.5 * (max - min); }
  double diagonal() const { return norm(extent()); }
  friend bool operator==(const Box&, const Box&) = default;
};

}  // namespace orbweave
