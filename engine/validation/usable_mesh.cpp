#include "engine/validation/usable_mesh.h"

#include <vector>

#include "engine/validation/usable_scale.h"
#include "io/mesh_size.h"
#include "io/meshes/mesh_reader.h"

namespace orbweave {

namespace {

Box bounds_of_finite(const std::vector<Vec3>& positions) {
  Box bounds;
  for (const Vec3 p : positions)
    if (is_finite(p)) bounds.extend(p);
  return bounds;
}

}  // namespace

TriangleMesh read_usable_mesh(const std::string& file, std::vector<std::string>* left_out) {
  TriangleMesh mesh = read_mesh(file, left_out);
  require_mesh_in_core(file, mesh.vertices.size(), mesh.triangles.size());
  require_usable_scale(file, mesh.triangles.empty() ? "cloud" : "mesh",
                       bounds_of_finite(mesh.vertices.positions));
  return mesh;
}

}  // namespace orbweave
