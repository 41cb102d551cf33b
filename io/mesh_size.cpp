#include "io/mesh_size.h"

#include "io/error.h"

namespace orbweave {

void require_mesh_in_core(const std::string& file, std::uint64_t vertices,
                          std::uint64_t triangles) {
  if (vertices <= kMostMeshVertices && triangles < kTooManyTriangles) return;
  throw_resource("the mesh is too large to be held in core",
                 {.file = file,
                  .place = {},
                  .found = std::to_string(vertices) + " vertices and " + std::to_string(triangles) +
                           " triangles",
                  .expected = "at most " + std::to_string(kMostMeshVertices) + " vertices and " +
                              std::to_string(kTooManyTriangles - 1) + " triangles",
                  .advice = "Use a part of it, or make it smaller ('orbweave simplify')."});
}

}  // namespace orbweave
