// Axes in a plane that only its normal is known of.
#pragma once

#include <cmath>

#include "io/vec3.h"

namespace orbweave {

/// Unit vectors at right angles to each other and to a normal, so that cross(u, v) is the normal.
struct PlaneAxes {
  Vec3 u, v;
};

/// Precondition: a unit vector. The coordinate axis that lies flattest in the plane, the first of
/// equals, becomes u.
inline PlaneAxes plane_axes(Vec3 normal) {
  int flattest = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (std::abs(normal[axis]) < std::abs(normal[flattest])) flattest = axis;
  Vec3 other;
  other[flattest] = 1.0;
  const Vec3 u = normalized(other - dot(other, normal) * normal);
  return {u, cross(normal, u)};
}

}  // namespace orbweave
