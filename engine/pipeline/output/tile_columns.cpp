#include "engine/pipeline/output/tile_columns.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "io/points/own_attribute.h"

namespace orbweave {
namespace {

ScalarType id_type(std::uint64_t vertices) {
  return vertices <= std::uint64_t{1} << 32 ? ScalarType::kUint32 : ScalarType::kInt64;
}

}  // namespace

PointSchema tile_schema(const MeshHeader& mesh) {
  PointSchema schema = mesh.schema;
  add_own_attribute(schema, {kVertexId, id_type(mesh.vertices)});
  return schema;
}

void add_vertex_ids(const MeshHeader& mesh, std::span<const std::uint64_t> ids, PointCloud& cloud) {
  PointSchema schema = tile_schema(mesh);
  const std::size_t width = mesh.schema.attribute_bytes();
  const std::size_t id_bytes = size_of(schema.attributes.back().type);
  std::vector<std::byte> attributes(ids.size() * (width + id_bytes));
  std::byte* out = attributes.data();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    out = std::copy_n(cloud.attributes.data() + i * width, width, out);
    const auto* id = reinterpret_cast<const std::byte*>(&ids[i]);  // little-endian: its low bytes
    out = std::copy_n(id, id_bytes, out);
  }
  cloud.attributes = std::move(attributes);
  cloud.schema = std::move(schema);
}

}  // namespace orbweave
