#include "engine/pipeline/surface/reconstruct_stage.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/ball_pivoting/halo_width.h"
#include "engine/ball_pivoting/perturbation.h"
#include "engine/normals/side_agreement.h"
#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/surface/chunk_with_halo.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/pipeline/surface/power_crust_stage.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "engine/pipeline/surface/super_cocone.h"
#include "engine/stitching/triangle_fans.h"

namespace orbweave {
namespace {

/// What stitching takes for a surface that is there already, bytes per vertex; an estimate.
constexpr std::uint64_t kStitchedBytes = 300;

/// The surface of all points, which are one chunk.
InCoreSurface surface_of_whole(const ChunkPoints& points, StageRunner& runner) {
  if (has_own_vertices(runner.job.reconstruct.method))
    return {with_fans(load_power_crust(runner.store), points.positions.size(), &runner.stop), {}};
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
  share_chunks(
      runner, clock, kMeshStage, std::move(tasks), plan.chunks_in_flight_bytes, [&](ChunkId chunk) {
        const ChunkPoints points =
            load_chunk_with_halo(runner.store, partition, chunk, 0.0, &runner.stop);
        InCoreSurface found = surface_of_whole(points, runner);
        ChunkMesh mesh = make_chunk_mesh(points, std::move(found.surface), chunks[chunk].box,
                                         longest_edge(inputs.radii.values), &runner.stop);
        mesh.undersampled = std::move(found.undersampled);
        mesh.voronoi.undersampled_points = static_cast<std::uint64_t>(
            std::count(mesh.undersampled.begin(), mesh.undersampled.end(), 1));
        commit_chunk_mesh(runner.store, chunk, mesh);
      });
  clock.facts().points = partition.points();
}

/// Whether the normals' side comes from outside: from the file or from the place of a scanner.
bool are_given(const NormalFacts& normals) {
  return normals.source == NormalSource::kFile || normals.orientation == Orientation::kScanner ||
         normals.orientation == Orientation::kViewpoint;
}

/// Which points are looked at: one in SideFacts::one_in() of the cloud's, by where they lie alone.
/// Of large clouds these lie in some cubes, so that their neighbours are found together.
class SideSample {
 public:
  SideSample(std::uint64_t points_of_cloud, double spacing)
      : cubes_(SideFacts::one_in(points_of_cloud) / kInCube),
        cubes_per_unit_(std::ldexp(1.0 / kSpacingsPerCube, -std::ilogb(spacing))) {}

  bool takes(Vec3 p) {
    if (cubes_ > 1) {
      const Vec3 cube = cube_of(p);
      if (!(cube == last_)) {
        last_ = cube;
        is_in_ = position_hash(cube) % cubes_ == 0;
      }
    }
    return is_in_ && position_hash(p) % kInCube == 0;
  }

 private:
  static constexpr std::uint64_t kInCube = SideFacts::one_in(0);  // one in so many points
  static constexpr double kSpacingsPerCube = 16.0;

  Vec3 cube_of(Vec3 p) const {
    return {std::floor(p.x * cubes_per_unit_), std::floor(p.y * cubes_per_unit_),
            std::floor(p.z * cubes_per_unit_)};
  }

  std::uint64_t cubes_;  // one in so many cubes
  double cubes_per_unit_;
  bool is_in_ = true;  // the cube of the last point
  Vec3 last_{std::numeric_limits<double>::infinity(), 0.0, 0.0};
};

/// Of the chunk's own points that are in the mesh: strays that the balls pass by do no harm.
SideFacts sides_of(const ChunkPoints& points, const ChunkMesh& mesh, SideSample sample,
                   double reach, const StopToken* stop) {
  if (points.owned_begin == points.owned_end) return {};
  std::vector<std::uint8_t> asked(points.owned_end - points.owned_begin);
  for (std::size_t i = 0; i < asked.size(); ++i)
    asked[i] = sample.takes(points.positions[points.owned_begin + i]) && mesh.fans[i] > 0 ? 1 : 0;
  return side_agreement(points.positions, points.normals,
                        {.begin = points.owned_begin,
                         .end = points.owned_end,
                         .first = points.global[points.owned_begin],
                         .reach = reach,
                         .asked = asked,
                         .stop = stop});
}

}  // namespace

void reconstruct_chunks(const SurfaceInputs& inputs, StageRunner& runner) {
  const Partition& partition = inputs.partition;
  const std::vector<double>& radii = inputs.radii.values;
  const bool is_super = is_super_cocone(runner.job, partition);
  by_root(runner, [&] {
    if (is_super) begin_cells(inputs, runner);
    begin_stage(runner, kMeshStage, stored_mesh_key(runner.job, runner.store, inputs));
    drop_stitch_of_unfinished_mesh(runner.store, partition);
  });
  if (is_super) return super_cocone(inputs, runner);
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
  const SideSample sample(partition.points(),
                          partition.spacing > 0.0 ? partition.spacing : radii.front());
  const MemoryPlan plan = runner.job.memory_plan(partition.points(), partition.schema);
  share_chunks(
      runner, clock, kMeshStage, std::move(tasks), plan.chunks_in_flight_bytes,
      [&](ChunkId chunk) {
        const ChunkPoints points =
            load_chunk_with_halo(runner.store, partition, chunk, halo, &runner.stop);
        BallPivotingResult result =
            ball_pivoting(points.positions, points.normals, points.owned, options);
        ChunkMesh mesh = make_chunk_mesh(points, std::move(result), chunks[chunk].box,
                                         longest_edge(radii), &runner.stop);
        if (are_given(partition.normals))
          mesh.sides = sides_of(points, mesh, sample, longest_edge(radii), &runner.stop);
        commit_chunk_mesh(runner.store, chunk, mesh);
      },
      Durability::kFollows);
  clock.facts().points = partition.points();
}

}  // namespace orbweave
