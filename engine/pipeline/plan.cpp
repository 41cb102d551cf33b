// What a run would do, from the counting pass and a sampling pass.
#include <algorithm>
#include <filesystem>
#include <optional>

#include "engine/ball_pivoting/automatic_radii.h"
#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/disk_plan.h"
#include "engine/pipeline/hole_stage.h"
#include "engine/pipeline/memory_forecast.h"
#include "engine/pipeline/partition_stage.h"
#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/prepare_stage.h"
#include "engine/pipeline/radii_choice.h"
#include "engine/pipeline/reconstruct_stage.h"
#include "engine/pipeline/scan_input.h"
#include "engine/pipeline/stage_keys.h"
#include "engine/pipeline/stitch_stage.h"
#include "engine/pipeline/time_forecast.h"
#include "engine/pipeline/used_vertices.h"
#include "io/chunk_points.h"
#include "io/error.h"
#include "io/glob.h"

namespace orbweave {
namespace {

/// The second pass of a run, for what it measures alone.
Partition sample(const InputContext& context, const CloudInput& input, const CountedCloud& cloud) {
  SpacingSampler sampler(cloud.octree.root(), cloud.grid);
  const auto source = input.open(nullptr);
  stream_points(*source, {.threads = context.threads(), .stop = &context.stop}, {},
                [&](StreamBatch& batch) { sampler.add(batch.points.positions); });
  Partition measured;
  measure(context, input, sampler, measured);
  return measured;
}

/// The passes over raw points, as far as the plan has found them out.
RawWork raw_work_of(const JobPlan& plan) {
  const bool estimates = plan.normals.source == "estimated";
  const bool propagates = plan.normals.orientation == name_of(Orientation::kPropagate);
  return {plan.prepare.options, estimates, estimates && propagates};
}

bool holds_a_mesh(const JobContext& context, const Partition& partition,
                  const std::vector<double>& radii) {
  if (!context.store.has_key(kMeshStage, mesh_key(context, partition, radii))) return false;
  for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk) {
    if (!context.store.has(kMeshStage, chunk)) return false;
  }
  return true;
}

/// The loops of the mesh that an earlier run of the same job left in its work directory.
std::optional<std::vector<HoleFacts>> stored_loops(const InputContext& input) {
  const std::filesystem::path directory = work_dir_of(input.job);
  if (!std::filesystem::exists(directory / "orbweave-store.json")) return std::nullopt;
  try {
    ChunkStore store(directory);
    RunReport report;
    report.files = input.files;
    Team alone;
    JobContext context{input, store, report, alone};
    if (!store.has_key(kPointsStage, points_key(input))) return std::nullopt;
    const std::optional<Partition> partition = stored_partition(store);
    if (!partition) return std::nullopt;
    const std::vector<double> radii = radii_of_job(context, *partition);
    if (!holds_a_mesh(context, *partition, radii)) return std::nullopt;
    std::optional<Stitched> stored = stored_stitch(context, *partition, radii);
    const Stitched stitched = stored ? std::move(*stored) : stitch_chunks(context, *partition);
    const UsedVertices used(store, *partition, stitched.used, {});
    VertexRanks ranks(used);
    std::vector<HoleFacts> loops = list_loops(stitched.boundary, input.job.fill);
    for (HoleFacts& loop : loops) loop.first_vertex = ranks.of(loop.first_vertex);
    return loops;
  } catch (const Error&) {
    return std::nullopt;  // in use by a run, or damaged: a plan can do without
  }
}

}  // namespace

JobPlan plan_job(const Job& job, Progress& progress, const StopToken& stop) {
  JobPlan plan;
  plan.files = expand_globs(job.input.files);
  const InputContext context{job, plan.files, progress, stop};
  progress.begin_stage("count", 0, "points");
  const CloudInput input = scans_as_input(context, kPointsStage, "");
  const CountedCloud cloud = count_points(context, input);
  progress.end_stage();
  progress.begin_stage("sample", 0, "points");
  Partition measured = sample(context, input, cloud);
  progress.end_stage();
  const bool given = !job.reconstruct.ball_radii.empty();
  plan.radii = given ? job.reconstruct.ball_radii : measured.automatic_radii;
  plan.radii_reason =
      given ? compare_with_spacing(plan.radii, measured.spacing) : measured.radii_reason;
  if (!plan.radii.empty()) plan.halo_width = halo_width(plan.radii);
  plan.prepare = clean_up_for(job.prepare, measured);
  plan.normals.source = "file";
  if (estimates_normals(context)) {
    plan.normals.source = "estimated";
    plan.normals.orientation = name_of(side_of_normals(job.normals, cloud.points_without_view));
  }
  plan.points = cloud.points_used;
  plan.bounds = cloud.grid.bounds();
  measured.octree = final_octree(context, cloud, measured);
  plan.chunks = measured.octree.chunks().size();
  plan.chunk_points = cloud.memory.chunk_points;
  for (const Chunk& chunk : measured.octree.chunks()) {
    plan.largest_chunk_points = std::max(plan.largest_chunk_points, chunk.points);
  }
  const std::size_t chunk_bytes =
      std::max<std::size_t>(1, plan.largest_chunk_points * MemoryCosts::kReconstructBytes);
  const auto affordable = cloud.memory.chunks_in_flight_bytes / chunk_bytes;
  plan.chunks_in_flight = static_cast<int>(
      std::clamp<std::size_t>(affordable, 1, static_cast<std::size_t>(context.threads()) + 1));
  measured.schema = cloud.schema;
  plan.peak_memory_bytes = predicted_peak_bytes(context, measured, plan.radii);
  plan.disk_bytes = plan_disk(job, cloud, raw_work_of(plan)).most_bytes;
  plan.seconds =
      predicted_seconds(context, plan.points, plan.radii, plan.normals, plan.prepare.options);
  if (job.fill.enabled) plan.loops = stored_loops(context);
  return plan;
}

}  // namespace orbweave
