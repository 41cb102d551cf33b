#include "io/mesh_reader.h"

#include "io/byte_source.h"
#include "io/ply_source.h"

namespace orbweave {

bool holds_faces(const std::filesystem::path& path) {
  return ply_holds_faces(open_byte_source(path));
}

TriangleMesh read_mesh(const std::filesystem::path& path) {
  return read_ply_mesh(open_byte_source(path));
}

}  // namespace orbweave
