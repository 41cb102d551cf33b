#include "engine/pipeline/output/picture_parts.h"

#include <algorithm>
#include <utility>

#include "engine/pipeline/surface/stored_mesh.h"
#include "engine/stitching/local_numbers.h"
#include "io/store/chunk_points.h"

namespace orbweave {
namespace {

PointCloud points_of(const StageRunner& runner, const Partition& partition, ChunkId chunk,
                     PartPoints points) {
  if (points == PartPoints::kNone) return {};
  PointSchema schema;
  schema.position_type = partition.schema.position_type;
  if (points == PartPoints::kAttributes) schema.attributes = partition.schema.attributes;
  return load_points(runner.store, chunk, schema, partition.stage);
}

}  // namespace

ChunkPart load_chunk_part(const StageRunner& runner, const ExportInputs& inputs, ChunkId chunk,
                          PartPoints points) {
  const Partition& partition = inputs.partition;
  ChunkPart part;
  part.points = points_of(runner, partition, chunk, points);
  part.first_vertex = partition.first_vertex[chunk];
  part.own = partition.points_in(chunk);
  ChunkMesh mesh = load_chunk_mesh(runner.store, chunk, false);
  part.triangles = std::move(mesh.triangles);
  part.undersampled = std::move(mesh.undersampled);
  part.outer_vertices = std::move(mesh.outer_vertices);
  part.outer_positions = std::move(mesh.outer_positions);
  const std::vector<Triangle64>& removed = inputs.holes.removed;
  if (removed.empty()) return part;
  const LocalNumbers numbers(part.first_vertex, part.own, part.outer_vertices);
  std::erase_if(part.triangles, [&](const Triangle& t) {
    return std::binary_search(removed.begin(), removed.end(), numbers.global(t));
  });
  return part;
}

BatchPart part_of(const PatchBatch& patches) {
  BatchPart part;
  for (const Triangle64& t : patches.triangles)
    part.vertices.insert(part.vertices.end(), t.begin(), t.end());
  std::sort(part.vertices.begin(), part.vertices.end());
  part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()), part.vertices.end());
  const auto number = [&](std::uint64_t vertex) {
    const auto at = std::lower_bound(part.vertices.begin(), part.vertices.end(), vertex);
    return static_cast<std::uint32_t>(at - part.vertices.begin());
  };
  part.triangles.reserve(patches.triangles.size());
  for (const Triangle64& t : patches.triangles)
    part.triangles.push_back({number(t[0]), number(t[1]), number(t[2])});
  return part;
}

EdgeComponents stored_components(const StageRunner& runner, const ExportInputs& inputs) {
  EdgeComponents components;
  const auto chunks = static_cast<ChunkId>(inputs.partition.octree.chunks().size());
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    runner.stop.check();
    const ChunkPart part = load_chunk_part(runner, inputs, chunk, PartPoints::kNone);
    components.add(part.triangles, [&](std::uint32_t vertex) { return part.global(vertex); });
  }
  std::uint64_t before = 0;  // new vertices of earlier batches
  for (ChunkId batch = 0; batch < inputs.holes.new_triangles.size(); ++batch) {
    runner.stop.check();
    const BatchPart part = part_of(load_patch_batch(runner.store, batch));
    components.add(part.triangles, [&](std::uint32_t number) {
      const std::uint64_t vertex = part.vertices[number];
      return vertex < kNewVertex ? vertex : vertex + before;
    });
    before += inputs.holes.new_vertices[batch];
  }
  components.finish();
  return components;
}

}  // namespace orbweave
