#include "engine/pipeline/surface/reconstruct_stage.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/pipeline/surface/power_crust_stage.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "engine/stitching/triangle_fans.h"
#include "io/store/chunk_points.h"

namespace orbweave {
namespace {

/// Puts a neighbour's points in their place, from `at` on; returns where they end.
std::size_t put(const PointsInBox& from, std::uint64_t first_vertex, std::size_t at,
                ChunkPoints& to) {
  const auto place = static_cast<std::ptrdiff_t>(at);
  std::copy(from.points.positions.begin(), from.points.positions.end(),
            to.positions.begin() + place);
  std::copy(from.points.normals.begin(), from.points.normals.end(), to.normals.begin() + place);
  for (const std::uint32_t row : from.rows) to.global[at++] = first_vertex + row;
  return at;
}

/// Puts the chunk's own points, read straight to their place.
std::size_t put_own(const ChunkStore& store, const Partition& partition, ChunkId chunk,
                    std::size_t at, ChunkPoints& to) {
  const std::size_t count = partition.points_in(chunk);
  load_oriented_points(store, chunk, partition.schema, std::span(to.positions).subspan(at, count),
                       std::span(to.normals).subspan(at, count), partition.stage);
  const auto first = to.global.begin() + static_cast<std::ptrdiff_t>(at);
  std::iota(first, first + static_cast<std::ptrdiff_t>(count), partition.first_vertex[chunk]);
  std::fill_n(to.owned.begin() + static_cast<std::ptrdiff_t>(at), count, std::uint8_t{1});
  to.owned_begin = static_cast<std::uint32_t>(at);
  to.owned_end = static_cast<std::uint32_t>(at + count);
  return at + count;
}

}  // namespace

ChunkPoints load_chunk_with_halo(const ChunkStore& store, const Partition& partition, ChunkId chunk,
                                 double halo, const StopToken* stop) {
  const Chunk& self = partition.octree.chunks()[chunk];
  const Box reach = self.box.grown(halo);
  std::vector<ChunkId> sources = partition.octree.neighbors(chunk, halo);
  sources.push_back(chunk);
  // Chunks in Morton order, points in canonical order within: the whole is in canonical order.
  std::sort(sources.begin(), sources.end());
  std::vector<PointsInBox> parts;
  std::size_t count = partition.points_in(chunk);
  for (const ChunkId source : sources) {
    check_stop(stop);
    parts.push_back(source == chunk ? PointsInBox{}
                                    : load_points_in_box(store, source, partition.schema, reach, {},
                                                         partition.stage));
    count += parts.back().rows.size();
  }
  ChunkPoints points;
  points.positions.resize(count);
  points.normals.resize(count);
  points.global.resize(count);
  points.owned.resize(count, 0);
  std::size_t at = 0;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    at = sources[i] == chunk ? put_own(store, partition, chunk, at, points)
                             : put(parts[i], partition.first_vertex[sources[i]], at, points);
    parts[i] = {};
  }
  return points;
}

namespace {

/// What stitching takes for a surface that is there already, bytes per vertex; measured.
constexpr std::uint64_t kStitchedBytes = 300;

/// The surface of all points, which are one chunk.
BallPivotingResult surface_of_whole(const ChunkPoints& points, StageRunner& runner) {
  if (has_own_vertices(runner.job.reconstruct.method))
    return with_fans(load_power_crust(runner.store), points.positions.size(), &runner.stop);
  return reconstruct_in_core(runner.job, points.positions, points.normals, &runner.stop,
                             progress_within_chunk(runner, points.positions.size()));
}

/// The method on all points, which are one chunk.
void reconstruct_whole(const SurfaceInputs& inputs, StageRunner& runner) {
  const Partition& partition = inputs.partition;
  const auto& chunks = partition.octree.chunks();
  const bool is_made = has_own_vertices(runner.job.reconstruct.method);
  if (!is_made) require_memory_for_method(runner.job, partition.points());
  const std::uint64_t per_point =
      is_made ? kStitchedBytes : costs_of(runner.job.reconstruct.method).bytes_per_point;
  StageClock clock(runner, Stage::kReconstruct, partition.points(), "points");
  std::vector<ChunkWork> tasks;
  for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk) {
    const std::uint64_t points = partition.points_in(chunk);
    tasks.push_back({chunk, points * per_point, points, points});
  }
  const MemoryPlan plan = runner.job.memory_plan(partition.points(), partition.schema);
  share_chunks(runner, clock, kMeshStage, std::move(tasks), plan.chunks_in_flight_bytes,
               [&](ChunkId chunk) {
                 const ChunkPoints points =
                     load_chunk_with_halo(runner.store, partition, chunk, 0.0, &runner.stop);
                 BallPivotingResult result = surface_of_whole(points, runner);
                 commit_chunk_mesh(runner.store, chunk,
                                   make_chunk_mesh(points, std::move(result), chunks[chunk].box,
                                                   2.0 * inputs.radii.values.back(), &runner.stop));
               });
  clock.facts().points = partition.points();
}

}  // namespace

void reconstruct_chunks(const SurfaceInputs& inputs, StageRunner& runner) {
  const Partition& partition = inputs.partition;
  const std::vector<double>& radii = inputs.radii.values;
  by_root(runner, [&] {
    begin_stage(runner, kMeshStage, stored_mesh_key(runner.job, runner.store, inputs));
    drop_stitch_of_unfinished_mesh(runner.store, partition);
  });
  if (is_in_core(runner.job.reconstruct.method)) return reconstruct_whole(inputs, runner);

  const auto& chunks = partition.octree.chunks();
  StageClock clock(runner, Stage::kReconstruct, chunks.size(), "chunks");
  const double halo = halo_width(radii);
  const auto points_in_reach = points_with_halos(runner.store, partition, halo);
  require_memory_for_largest(runner.job, partition, points_in_reach, radii);
  std::vector<ChunkWork> tasks;
  for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk) {
    const std::uint64_t points = points_in_reach[chunk];
    tasks.push_back(
        {chunk, points * MemoryCosts::kReconstructBytes, points, partition.points_in(chunk)});
  }
  const BallPivotingOptions options{.ball_radii = radii, .stop = &runner.stop};
  const MemoryPlan plan = runner.job.memory_plan(partition.points(), partition.schema);
  share_chunks(runner, clock, kMeshStage, std::move(tasks), plan.chunks_in_flight_bytes,
               [&](ChunkId chunk) {
                 const ChunkPoints points =
                     load_chunk_with_halo(runner.store, partition, chunk, halo, &runner.stop);
                 BallPivotingResult result =
                     ball_pivoting(points.positions, points.normals, points.owned, options);
                 commit_chunk_mesh(runner.store, chunk,
                                   make_chunk_mesh(points, std::move(result), chunks[chunk].box,
                                                   2.0 * radii.back(), &runner.stop));
               });
  clock.facts().points = partition.points();
}

}  // namespace orbweave
