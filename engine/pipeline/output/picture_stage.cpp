#include "engine/pipeline/output/picture_stage.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "engine/pipeline/stage/writer_options.h"
#include "engine/pipeline/surface/patch_batch.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "engine/stitching/local_numbers.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "io/store/chunk_points.h"

namespace orbweave {
namespace {

using Corners = std::array<Vec3, 3>;

/// The samples of a picture keep the nearest triangle whatever the order of drawing.
void draw_on_all_threads(std::span<const Corners> corners, std::span<const std::int32_t> hole,
                         MeshPicture& picture) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, corners.size(), 4096),
                    [&](const auto& range) {
                      picture.draw(corners.subspan(range.begin(), range.size()),
                                   hole.empty() ? hole : hole.subspan(range.begin(), range.size()));
                    });
}

std::vector<Vec3> positions_of(const StageRunner& runner, const Partition& partition,
                               ChunkId chunk) {
  PointSchema positions_alone;
  positions_alone.position_type = partition.schema.position_type;
  return load_points(runner.store, chunk, positions_alone).positions;
}

/// The triangles of a chunk that no patch replaces.
std::vector<Corners> corners_of(const StageRunner& runner, const ExportInputs& inputs,
                                ChunkId chunk) {
  const std::vector<Vec3> own = positions_of(runner, inputs.partition, chunk);
  const ChunkMesh mesh = load_chunk_mesh(runner.store, chunk, false);
  const LocalNumbers numbers(inputs.partition.first_vertex[chunk], own.size(), mesh.outer_vertices);
  const std::vector<Triangle64>& removed = inputs.holes.removed;
  const auto position = [&](std::uint32_t vertex) {
    return vertex < own.size() ? own[vertex] : mesh.outer_positions[vertex - own.size()];
  };
  std::vector<Corners> corners;
  corners.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    if (!removed.empty() && std::binary_search(removed.begin(), removed.end(), numbers.global(t)))
      continue;
    corners.push_back({position(t[0]), position(t[1]), position(t[2])});
  }
  return corners;
}

/// Consecutive batches of patches, and the vertices of the scanned surface at their rims.
struct PatchGroup {
  ChunkId begin = 0, end = 0;
  std::vector<std::uint64_t> rim;  ///< ascending
  std::vector<Vec3> positions;     ///< of the rim
};

/// Takes batches from `begin` on, until their rims have a million vertices.
PatchGroup group_from(const StageRunner& runner, const FilledHoles& holes, ChunkId begin) {
  constexpr std::size_t kMostVertices = std::size_t{1} << 20;
  PatchGroup group{begin, begin, {}, {}};
  while (group.end < holes.new_triangles.size() && group.rim.size() < kMostVertices) {
    runner.stop.check();
    for (const Triangle64& t : load_patch_batch(runner.store, group.end++).triangles)
      for (const std::uint64_t vertex : t)
        if (vertex < kNewVertex) group.rim.push_back(vertex);
    std::sort(group.rim.begin(), group.rim.end());
    group.rim.erase(std::unique(group.rim.begin(), group.rim.end()), group.rim.end());
  }
  return group;
}

/// Patches touch chunks in any order, so each chunk is read once for all of them.
void place_rims(const StageRunner& runner, const Partition& partition, PatchGroup& group) {
  group.positions.reserve(group.rim.size());
  while (group.positions.size() < group.rim.size()) {
    runner.stop.check();
    const ChunkId chunk = partition.chunk_of(group.rim[group.positions.size()]);
    const std::vector<Vec3> own = positions_of(runner, partition, chunk);
    for (std::size_t i = group.positions.size();
         i < group.rim.size() && group.rim[i] < partition.first_vertex[chunk + 1]; ++i)
      group.positions.push_back(own[group.rim[i] - partition.first_vertex[chunk]]);
  }
}

void draw_group(const StageRunner& runner, const PatchGroup& group, MeshPicture& picture) {
  for (ChunkId batch = group.begin; batch < group.end; ++batch) {
    runner.stop.check();
    const PatchBatch patches = load_patch_batch(runner.store, batch);
    const auto position = [&](std::uint64_t vertex) {
      if (vertex >= kNewVertex) return patches.positions[vertex - kNewVertex];
      const auto at = std::lower_bound(group.rim.begin(), group.rim.end(), vertex);
      return group.positions[static_cast<std::size_t>(at - group.rim.begin())];
    };
    std::vector<Corners> corners;
    for (const Triangle64& t : patches.triangles)
      corners.push_back({position(t[0]), position(t[1]), position(t[2])});
    draw_on_all_threads(corners, patches.hole, picture);
  }
}

/// The scanned surface chunk by chunk, then the patches.
void draw_mesh(const ExportInputs& inputs, StageRunner& runner, MeshPicture& picture) {
  const auto chunks = static_cast<ChunkId>(inputs.partition.octree.chunks().size());
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    runner.stop.check();
    draw_on_all_threads(corners_of(runner, inputs, chunk), {}, picture);
    runner.progress.advance(1);
  }
  for (ChunkId batch = 0; batch < inputs.holes.new_triangles.size();) {
    PatchGroup group = group_from(runner, inputs.holes, batch);
    place_rims(runner, inputs.partition, group);
    draw_group(runner, group, picture);
    batch = group.end;
  }
}

}  // namespace

void draw_picture(const ExportInputs& inputs, StageRunner& runner) {
  const Partition& partition = inputs.partition;
  const auto chunks = static_cast<ChunkId>(partition.octree.chunks().size());
  const StageClock clock(runner, Stage::kPicture, chunks, "chunks");
  const OutputOptions& output = runner.job.output;
  PictureOptions options;
  options.up = picture_up(runner.job, partition.coordinate_system);
  options.patch_color = output.patch_color;
  if (output.picture_colors == PictureColors::kConfidence)
    options.confidence = confidence_of_patches(inputs.holes.holes);
  MeshPicture picture(partition.bounds, options);
  const PictureBacks backs = output.picture_backs;
  if (backs == PictureBacks::kCulled) picture.leave_out_backs();
  draw_mesh(inputs, runner, picture);
  if (backs == PictureBacks::kAuto && may_be_interior(runner.job) && picture.shows_backs()) {
    picture.leave_out_backs();
    draw_mesh(inputs, runner, picture);
  }
  picture.write_png(output.picture);
}

}  // namespace orbweave
