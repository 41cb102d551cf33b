#include "engine/pipeline/output/vertex_columns.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "engine/pipeline/surface/stored_mesh.h"
#include "io/points/own_attribute.h"
#include "io/store/chunk_points.h"

namespace orbweave {
namespace {

PointSchema with_undersampled(PointSchema schema) {
  add_own_attribute(schema, {kUndersampledColumn, ScalarType::kUint8});
  return schema;
}

/// `flags`: one per point.
void add_column(PointCloud& points, std::span<const std::uint8_t> flags) {
  const std::size_t width = points.schema.attribute_bytes();
  std::vector<std::byte> attributes(flags.size() * (width + 1));
  std::byte* out = attributes.data();
  for (std::size_t i = 0; i < flags.size(); ++i) {
    out = std::copy_n(points.attributes.data() + i * width, width, out);
    *out++ = static_cast<std::byte>(flags[i]);
  }
  points.attributes = std::move(attributes);
  points.schema = with_undersampled(std::move(points.schema));
}

}  // namespace

VertexColumns vertex_columns(const Partition& partition, const OutputOptions& output) {
  VertexColumns columns{partition.schema, output.vertex_undersampled, {}};
  columns.stored.has_normals = columns.stored.has_normals && output.attributes;
  columns.colors =
      ColorDepth(columns.undersampled ? with_undersampled(columns.stored) : columns.stored,
                 output.color_bits, partition.has_wide_colors);
  return columns;
}

void load_vertex_rows(const ChunkStore& store, const std::string& stage, ChunkId chunk,
                      const VertexColumns& columns, std::uint64_t first, std::uint64_t count,
                      PointCloud& points) {
  load_point_rows(store, chunk, columns.stored, first, count, points, stage);
  if (!columns.undersampled) return;
  std::vector<std::uint8_t> flags(count);
  store.open(kMeshStage, chunk)->read(kStoredUndersampled, first, count, flags.data());
  add_column(points, flags);
}

void mark_unsampled(const VertexColumns& columns, PointCloud& vertices) {
  if (!columns.undersampled) return;
  add_column(vertices, std::vector<std::uint8_t>(vertices.size(), kNoSample));
}

}  // namespace orbweave
