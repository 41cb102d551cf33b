// The stored mesh in parts, as a picture is drawn from it: the scanned surface chunk by chunk, then
// the patches batch by batch.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/edge_components.h"
#include "engine/pipeline/output/export_stage.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/pipeline/surface/patch_batch.h"
#include "io/point_cloud.h"

namespace orbweave {

/// What is read of a chunk's own points.
enum class PartPoints { kNone, kPositions, kAttributes };

/// The triangles of a chunk that no patch replaces, in the chunk's own numbers.
struct ChunkPart {
  std::vector<Triangle> triangles;
  PointCloud points;  ///< the chunk's own, as far as they were asked for
  /// Per own point, where the method tells.
  std::vector<std::uint8_t> undersampled;
  std::vector<std::uint64_t> outer_vertices;
  std::vector<Vec3> outer_positions;
  std::uint64_t first_vertex = 0;  ///< global number of the first own point
  std::uint64_t own = 0;           ///< points

  Vec3 position(std::uint32_t vertex) const {
    return vertex < own ? points.positions[vertex] : outer_positions[vertex - own];
  }
  std::uint64_t global(std::uint32_t vertex) const {
    return vertex < own ? first_vertex + vertex : outer_vertices[vertex - own];
  }
};
ChunkPart load_chunk_part(const StageRunner& runner, const ExportInputs& inputs, ChunkId chunk,
                          PartPoints points);

/// The triangles of a batch of patches, numbered from 0 by their vertices in ascending order.
struct BatchPart {
  std::vector<Triangle> triangles;
  std::vector<std::uint64_t> vertices;  ///< per number; new ones from kNewVertex on, of the batch
};
BatchPart part_of(const PatchBatch& patches);

/// The components of the whole mesh, patches among them: parts are the chunks, then the batches.
EdgeComponents stored_components(const StageRunner& runner, const ExportInputs& inputs);

}  // namespace orbweave
