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
  /// No point of one surface is farther from the other; at most a tenth more than the largest
  /// distance that was met, but where the quadrics say more or triangles are far larger than
  /// that. In the unit of the positions.
  double error = 0.0;
};

/// At most `target` triangles where borders allow: vertices on edges of one triangle all stay. The
/// result depends on the input alone. About 200 bytes per triangle while it works.
Simplification simplify_inside(std::span<const Vec3> positions,
                               std::span<const Triangle> triangles, std::size_t target);

}  // namespace orbweave
