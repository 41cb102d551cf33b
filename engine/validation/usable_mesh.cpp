#include "engine/validation/usable_mesh.h"

#include "io/mesh_size.h"
#include "io/meshes/mesh_reader.h"

namespace orbweave {

TriangleMesh read_usable_mesh(const std::string& file) {
  TriangleMesh mesh = read_mesh(file);
  require_mesh_in_core(file, mesh.vertices.size(), mesh.triangles.size());
  return mesh;
}

}  // namespace orbweave
