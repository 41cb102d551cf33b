// Points spread over a mesh by area.
#pragma once

#include <cstdint>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// `normals`: unit normals of the triangles that the points lie on.
struct AreaSamples {
  std::vector<Vec3> positions, normals;
};

/// `count` points, one in each of as many parts of equal area, or none where the mesh has no area.
/// Places within triangles follow Roberts: The unreasonable effectiveness of quasirandom sequences,
/// 2018 (R2). Triangles with vertices that are not finite are left out. Indices in range. The same
/// mesh and count give the same points.
AreaSamples sample_by_area(const TriangleMesh& mesh, std::uint64_t count);

}  // namespace orbweave
