// Bounds of points.
#pragma once

#include <span>

#include "io/box.h"

namespace orbweave {

/// The smallest box around points; empty where there are none.
inline Box bounds_of(std::span<const Vec3> points) {
  Box box;
  for (const Vec3& p : points) box.extend(p);
  return box;
}

}  // namespace orbweave
