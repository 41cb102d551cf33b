#include "engine/pipeline/surface/super_cocone.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/surface/chunk_with_halo.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/pipeline/surface/seam_agreement.h"
#include "engine/pipeline/surface/stored_cells.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "engine/stitching/triangle_fans.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/store/chunk_points.h"
#include "io/text/quantity.h"
#include "partition/memory_plan.h"

namespace orbweave {
namespace {

double halo_of(const Chunk& chunk, double share) { return share * chunk.box.largest_extent(); }

/// At most as many points as lie within a share of its side of each chunk, by the bounds of blocks.
class PointsAround {
 public:
  PointsAround(const ChunkStore& store, const Partition& partition) : partition_(partition) {
    for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk)
      blocks_.push_back(stored_block_bounds(store, chunk));
  }

  std::uint64_t count(ChunkId chunk, double share) const {
    const Chunk& self = partition_.octree.chunks()[chunk];
    const double halo = halo_of(self, share);
    const Box reach = self.box.grown(halo);
    std::uint64_t points = partition_.points_in(chunk);
    for (const ChunkId other : partition_.octree.neighbors(chunk, halo)) {
      const auto met = std::count_if(blocks_[other].begin(), blocks_[other].end(),
                                     [&](const Box& box) { return box.intersects(reach); });
      points +=
          std::min(partition_.points_in(other), static_cast<std::uint64_t>(met) * kPointBlockRows);
    }
    return points;
  }

 private:
  const Partition& partition_;
  std::vector<std::vector<Box>> blocks_;
};

/// How much of a chunk's surroundings the budget has room for.
struct CellTask {
  std::uint64_t points = 0;
  bool may_grow = false;
};

std::uint64_t needed_bytes(const Job& job, std::uint64_t points) {
  return MemoryCosts::kBaseBytes + points * costs_of(job.reconstruct.method).bytes_per_point;
}

CellTask plan_cells(const Job& job, const Partition& partition, const PointsAround& around,
                    ChunkId chunk) {
  const std::uint64_t grown = around.count(chunk, kGrownCoconeHalo);
  const std::uint64_t budget = job.partition.memory_bytes;
  if (needed_bytes(job, grown) <= budget) return {grown, true};
  const std::uint64_t points = around.count(chunk, kCoconeHalo);
  const std::uint64_t needed = needed_bytes(job, points);
  if (needed <= budget) return {points, false};
  throw_resource(
      "the memory budget is too small for a chunk and what lies around it",
      {.place = setting_name(job, "partition.memory"),
       .found = format_bytes(budget) + "; around chunk " + std::to_string(chunk) + " with its " +
                format_count(partition.points_in(chunk)) + " points, " + format_count(points) +
                " of some " + std::to_string(costs_of(job.reconstruct.method).bytes_per_point) +
                " bytes",
       .expected = "at least " + std::to_string((needed >> 20) + 1) + " MiB",
       .advice = "Or a smaller " + setting_name(job, "partition.chunk_points") + ", or " +
                 setting_name(job, "cleaning.thin_to_spacing")});
}

std::uint64_t count_own(const ChunkPoints& points, const std::vector<std::uint8_t>& flags,
                        std::uint8_t value) {
  return static_cast<std::uint64_t>(
      std::count(flags.begin() + points.owned_begin, flags.begin() + points.owned_end, value));
}

/// What a chunk keeps of the Cocone of its box.
ChunkCells cells_of(const ChunkPoints& points, const CoconeOfPart& part) {
  ChunkCells cells;
  for (const Triangle& t : part.triangles) {
    const int own = (points.is_owned(t[0]) ? 1 : 0) + (points.is_owned(t[1]) ? 1 : 0) +
                    (points.is_owned(t[2]) ? 1 : 0);
    if (own == 0) continue;
    const Triangle64 global = {points.global[t[0]], points.global[t[1]], points.global[t[2]]};
    (own == 3 ? cells.inner : cells.seam).push_back(global);
  }
  cells.undersampled.assign(part.undersampled.begin() + points.owned_begin,
                            part.undersampled.begin() + points.owned_end);
  cells.facts.undersampled_points = count_own(points, part.undersampled, 1);
  cells.facts.uncertified_points = count_own(points, part.certified, 0);
  return cells;
}

ChunkCells find_cells(const StageRunner& runner, const Partition& partition, ChunkId chunk,
                      bool may_grow) {
  const Chunk& self = partition.octree.chunks()[chunk];
  const auto find = [&](double share) {
    const double halo = halo_of(self, share);
    const ChunkPoints points =
        load_chunk_with_halo(runner.store, partition, chunk, halo, &runner.stop);
    return cells_of(points, cocone_of_part(points.positions, points.normals, self.box.grown(halo),
                                           partition.bounds, &runner.stop));
  };
  ChunkCells cells = find(kCoconeHalo);
  if (cells.facts.uncertified_points == 0 || !may_grow) return cells;
  cells = find(kGrownCoconeHalo);
  cells.facts.grown_boxes = 1;
  return cells;
}

bool has_whole_mesh(StageRunner& runner, const Partition& partition) {
  bool is_whole = true;
  for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk)
    is_whole = is_whole && runner.store.has(kMeshStage, chunk);
  // The root decides: another process may see the directory as it was a moment ago.
  return runner.communicator.broadcast(is_whole ? 1 : 0, runner.stop) != 0;
}

void make_cells(const SurfaceInputs& inputs, StageRunner& runner) {
  const Partition& partition = inputs.partition;
  const auto chunks = static_cast<ChunkId>(partition.octree.chunks().size());
  StageClock clock(runner, Stage::kCells, chunks, "chunks");
  const PointsAround around(runner.store, partition);
  std::vector<CellTask> plans;
  std::vector<ChunkWork> tasks;
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    plans.push_back(plan_cells(runner.job, partition, around, chunk));
    const std::uint64_t points = plans.back().points;
    tasks.push_back({chunk, points * costs_of(runner.job.reconstruct.method).bytes_per_point,
                     points, partition.points_in(chunk)});
  }
  const MemoryPlan plan = runner.job.memory_plan(partition.points(), partition.schema);
  share_chunks(runner, clock, kCellStage, std::move(tasks), plan.chunks_in_flight_bytes,
               [&](ChunkId chunk) {
                 commit_cells(runner.store, chunk,
                              find_cells(runner, partition, chunk, plans[chunk].may_grow));
               });
  clock.facts().points = partition.points();
}

/// The triangles in the numbers of the points, with the fans at all vertices of those that the
/// chunk owns.
BallPivotingResult surface_of(const ChunkPoints& points, const std::vector<Triangle64>& triangles,
                              const StopToken* stop) {
  const auto number = [&](std::uint64_t vertex) {
    const auto at = std::lower_bound(points.global.begin(), points.global.end(), vertex);
    return static_cast<std::uint32_t>(at - points.global.begin());
  };
  std::vector<Triangle> local;
  local.reserve(triangles.size());
  for (const Triangle64& t : triangles) local.push_back({number(t[0]), number(t[1]), number(t[2])});
  BallPivotingResult result = with_fans(std::move(local), points.global.size(), stop);
  std::erase_if(result.triangles, [&](const Triangle& t) { return !points.is_owned(t[0]); });
  return result;
}

ChunkMesh agreed_mesh(const StageRunner& runner, const SurfaceInputs& inputs, ChunkId chunk) {
  const Partition& partition = inputs.partition;
  const double longest = 2.0 * inputs.radii.values.back();
  ChunkCells cells = load_cells(runner.store, chunk);
  SeamAgreement agreement(runner.store, partition, longest);
  const AgreedTriangles agreed = agreement.of(chunk, cells);
  const ChunkPoints points = agreement.points_of(chunk, agreed.all);
  ChunkMesh mesh = make_chunk_mesh(points, surface_of(points, agreed.all, &runner.stop),
                                   partition.octree.chunks()[chunk].box, longest, &runner.stop);
  mesh.undersampled = std::move(cells.undersampled);
  mesh.voronoi = cells.facts;
  mesh.voronoi.contested_triangles = agreed.contested;
  mesh.voronoi.seam_triangles = agreed.seam;
  return mesh;
}

void agree(const SurfaceInputs& inputs, StageRunner& runner) {
  const Partition& partition = inputs.partition;
  const auto chunks = static_cast<ChunkId>(partition.octree.chunks().size());
  StageClock clock(runner, Stage::kReconstruct, chunks, "chunks");
  std::vector<ChunkWork> tasks;
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    const std::uint64_t points = partition.points_in(chunk);
    tasks.push_back({chunk, points * MemoryCosts::kReconstructBytes, points, points});
  }
  const MemoryPlan plan = runner.job.memory_plan(partition.points(), partition.schema);
  share_chunks(runner, clock, kMeshStage, std::move(tasks), plan.chunks_in_flight_bytes,
               [&](ChunkId chunk) {
                 commit_chunk_mesh(runner.store, chunk, agreed_mesh(runner, inputs, chunk));
               });
  clock.facts().points = partition.points();
}

}  // namespace

void begin_cells(const SurfaceInputs& inputs, StageRunner& runner) {
  begin_stage(runner, kCellStage,
              stored_mesh_key(runner.job, runner.store, inputs) + key_line("layout of cells", "2"));
}

void super_cocone(const SurfaceInputs& inputs, StageRunner& runner) {
  require_method(runner.job);
  if (!has_whole_mesh(runner, inputs.partition)) make_cells(inputs, runner);
  agree(inputs, runner);
}

}  // namespace orbweave
