// The codecs are those of the glTF extension EXT_meshopt_compression (Khronos, 2021): version 0 for
// vertices, version 1 for triangles. Both tell what differs from what came before, so the order of
// vertices and triangles decides how small a tile becomes.
#include "engine/levels/packed_tile.h"

#include <meshoptimizer.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/levels/tileset_index.h"
#include "io/meshes/glb_layout.h"

namespace orbweave {
namespace {

using Indices = std::vector<unsigned int>;

unsigned char* bytes_of(std::string& text) { return reinterpret_cast<unsigned char*>(text.data()); }

/// The library keeps the versions for the whole process, so they are set once.
void set_codec_versions() {
  static const bool kAreSet = [] {
    meshopt_encodeVertexVersion(0);
    meshopt_encodeIndexVersion(1);
    return true;
  }();
  static_cast<void>(kAreSet);
}

Indices ordered_indices(const TriangleMesh& mesh) {
  Indices indices;
  indices.reserve(3 * mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  meshopt_optimizeVertexCacheStrip(indices.data(), indices.data(), indices.size(),
                                   mesh.vertices.size());
  return indices;
}

/// Puts rows of vertices in the order in which triangles need them; `indices` follow.
void order_as_needed(std::vector<std::byte>& rows, std::size_t row_bytes, Indices& indices) {
  const std::size_t vertices = rows.size() / row_bytes;
  Indices places(vertices);
  const std::size_t needed =
      meshopt_optimizeVertexFetchRemap(places.data(), indices.data(), indices.size(), vertices);
  if (needed != vertices) throw std::logic_error("a vertex of a tile has no triangle");
  meshopt_remapIndexBuffer(indices.data(), indices.data(), indices.size(), places.data());
  meshopt_remapVertexBuffer(rows.data(), rows.data(), vertices, row_bytes, places.data());
}

void check_encoded(std::size_t bytes) {
  if (bytes == 0) throw std::logic_error("a compressed tile is larger than its bound");
}

std::string packed_vertices(std::span<const std::byte> rows, std::size_t row_bytes) {
  const std::size_t count = rows.size() / row_bytes;
  std::string packed(meshopt_encodeVertexBufferBound(count, row_bytes), '\0');
  packed.resize(
      meshopt_encodeVertexBuffer(bytes_of(packed), packed.size(), rows.data(), count, row_bytes));
  check_encoded(packed.size());
  return packed;
}

std::string packed_triangles(const Indices& indices, std::size_t vertices) {
  std::string packed(meshopt_encodeIndexBufferBound(indices.size(), vertices), '\0');
  packed.resize(
      meshopt_encodeIndexBuffer(bytes_of(packed), packed.size(), indices.data(), indices.size()));
  check_encoded(packed.size());
  return packed;
}

}  // namespace

void write_packed_tile(const std::filesystem::path& file, const TriangleMesh& mesh,
                       const MeshWriterOptions& options) {
  set_codec_versions();
  const PointCloud& vertices = mesh.vertices;
  MeshHeader header;
  header.vertices = vertices.size();
  header.triangles = mesh.triangles.size();
  header.schema = vertices.schema;
  const GlbLayout layout(header, options);
  std::vector<std::byte> rows(vertices.size() * layout.vertex_bytes());
  layout.put_vertices(vertices, rows.data());
  Indices indices = ordered_indices(mesh);
  order_as_needed(rows, layout.vertex_bytes(), indices);
  const PackedRows packed{packed_vertices(rows, layout.vertex_bytes()),
                          packed_triangles(indices, vertices.size())};
  write_text_file(file, layout.packed_file(vertices.bounds(), packed));
}

}  // namespace orbweave
