#include "engine/validation/usable_mesh.h"

#include <vector>

#include "engine/validation/usable_scale.h"
#include "io/bounds.h"
#include "io/mesh_size.h"
#include "io/meshes/mesh_reader.h"

namespace orbweave {

TriangleMesh read_usable_mesh(const std::string& file, std::vector<std::string>* left_out) {
  TriangleMesh mesh = read_mesh(file, left_out);
  require_mesh_in_core(file, mesh.vertices.size(), mesh.triangles.size());
  require_usable_scale(file, mesh.triangles.empty() ? "cloud" : "mesh",
                       bounds_of_finite(mesh.vertices.positions));
  return mesh;
}

}  // namespace orbweave
