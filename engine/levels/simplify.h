// Fewer triangles for a mesh, its border as it is.
//
// Garland and Heckbert, Surface Simplification Using Quadric Error Metrics, 1997, as meshoptimizer
// does it: edges collapse into one of their ends, so vertices stay where they are.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

struct Simplification {
  std::vector<Triangle> triangles;  ///< over the vertices of the mesh that was given
  /// How far the two surfaces are apart, in the unit of the positions: a quarter more than the
  /// largest distance from each vertex that is gone to the new surface and from four points of
  /// each new triangle to the old one; no less than what the quadrics say.
  double error = 0.0;
};

/// At most `target` triangles where borders allow: vertices on edges of one triangle all stay. The
/// result depends on the input alone. About 200 bytes per triangle while it works.
Simplification simplify_inside(std::span<const Vec3> positions, std::span<const Triangle> triangles,
                               std::size_t target);

}  // namespace orbweave
