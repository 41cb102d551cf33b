// Bounds of points and surfaces.
#pragma once

#include <cstdint>
#include <span>

#include "io/box.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// The smallest box around points; empty where there are none.
inline Box bounds_of(std::span<const Vec3> points) {
  Box box;
  for (const Vec3& p : points) box.extend(p);
  return box;
}

/// The smallest box around the points that are finite.
inline Box bounds_of_finite(std::span<const Vec3> points) {
  Box box;
  for (const Vec3& p : points)
    if (is_finite(p)) box.extend(p);
  return box;
}

/// The smallest box around the finite vertices that triangles use: others, far away, would make the
/// surface a speck. Indices in range.
inline Box bounds_of_surface(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  Box box;
  for (const Triangle& t : triangles)
    for (const std::uint32_t corner : t)
      if (is_finite(positions[corner])) box.extend(positions[corner]);
  return box;
}

}  // namespace orbweave
