// What a run would do, from the counting pass and a sampling pass.
#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/budget/disk_plan.h"
#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/budget/time_forecast.h"
#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/points/cleaning_stage.h"
#include "engine/pipeline/points/cloud_measure.h"
#include "engine/pipeline/points/count_stage.h"
#include "engine/pipeline/points/scan_input.h"
#include "engine/pipeline/stage/cleaning_rule.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "engine/pipeline/surface/hole_stage.h"
#include "engine/pipeline/surface/radii_choice.h"
#include "engine/pipeline/surface/stitch_stage.h"
#include "engine/pipeline/surface/used_vertices.h"
#include "io/error.h"
#include "io/system/glob.h"

namespace orbweave {
namespace {

CountedCloud count(const RunControl& control, const CloudInput& input) {
  control.progress.begin_stage(name_of(input.stages.count), 0, "points");
  CountedCloud cloud = count_points(control, input);
  control.progress.end_stage();
  return cloud;
}

/// The second pass of a run, for what it measures alone.
Partition sample(const RunControl& control, const CloudInput& input, const CountedCloud& cloud) {
  control.progress.begin_stage("sample", 0, "points");
  SpacingSampler sampler(cloud.octree.root(), cloud.grid);
  const auto source = input.open(nullptr);
  stream_points(*source,
                {.threads = control.threads(), .stop = &control.stop, .filter = &cloud.filter}, {},
                [&](StreamBatch& batch) { sampler.add(batch.points.positions); });
  Partition measured = measure(input, sampler, control);
  control.progress.end_stage();
  return measured;
}

NormalFacts normals_of(const ResolvedJob& job, const CountedCloud& cloud) {
  NormalFacts normals;
  normals.source = NormalSource::kFile;
  if (!job.estimates_normals) return normals;
  normals.source = NormalSource::kEstimate;
  normals.orientation = job.orientation_rule(cloud.points_without_view);
  return normals;
}

/// The passes over raw points, as far as the plan has found them out.
RawWork raw_work_of(const JobPlan& plan) {
  const bool estimates = plan.normals.source == NormalSource::kEstimate;
  const bool propagates = plan.normals.orientation == Orientation::kPropagate;
  return {plan.cleaning.options, estimates, estimates && propagates};
}

bool holds_a_mesh(const ResolvedJob& job, const ChunkStore& store, const SurfaceInputs& inputs) {
  if (!store.has_key(kMeshStage, stored_mesh_key(job, store, inputs))) return false;
  for (ChunkId chunk = 0; chunk < inputs.partition.octree.chunks().size(); ++chunk) {
    if (!store.has(kMeshStage, chunk)) return false;
  }
  return true;
}

std::vector<HoleFacts> loops_of(const Stitched& stitched, const FillOptions& fill,
                                const UsedVertices& used) {
  VertexRanks ranks(used);
  std::vector<HoleFacts> loops = list_loops(stitched.boundary, fill);
  for (HoleFacts& loop : loops) loop.first_vertex = value_of(ranks.of(loop.first_vertex));
  return loops;
}

/// The loops of the mesh that an earlier run of the same job left in its work directory.
std::optional<std::vector<HoleFacts>> stored_loops(const ResolvedJob& job, const StopToken& stop) {
  const std::filesystem::path directory = work_dir_of(job);
  if (!std::filesystem::exists(directory / "orbweave-store.json")) return std::nullopt;
  try {
    ChunkStore store(directory);
    if (!store.has_key(kPointsStage, points_key(job))) return std::nullopt;
    const std::optional<Partition> partition = stored_partition(store);
    if (!partition) return std::nullopt;
    const BallRadii radii = radii_of_job(job, *partition);
    const SurfaceInputs inputs{*partition, radii};
    if (!holds_a_mesh(job, store, inputs)) return std::nullopt;
    std::optional<Stitched> stored = stored_stitch(inputs, job, store);
    const Stitched stitched = stored ? std::move(*stored) : stitch_chunks(inputs, job, store, stop);
    const UsedVertices used(store, *partition, stitched.used, {});
    return loops_of(stitched, job.fill, used);
  } catch (const Error&) {
    return std::nullopt;  // in use by a run, or damaged: a plan can do without
  }
}

/// Chunks and their sizes. `measured` gets the octree.
void plan_chunks(const ResolvedJob& job, const CountedCloud& cloud, Partition& measured,
                 JobPlan& plan) {
  measured.octree = final_octree(job, cloud, measured);
  plan.chunks = measured.octree.chunks().size();
  plan.chunk_points = cloud.memory.chunk_points;
  for (const Chunk& chunk : measured.octree.chunks())
    plan.largest_chunk_points = std::max(plan.largest_chunk_points, chunk.points);
  const std::size_t chunk_bytes =
      std::max<std::size_t>(1, plan.largest_chunk_points * MemoryCosts::kReconstructBytes);
  const auto affordable = cloud.memory.chunks_in_flight_bytes / chunk_bytes;
  plan.chunks_in_flight = static_cast<int>(
      std::clamp<std::size_t>(affordable, 1, static_cast<std::size_t>(job.threads()) + 1));
}

void plan_radii(const ResolvedJob& job, const Partition& measured, JobPlan& plan) {
  const bool given = !job.reconstruct.ball_radii.empty();
  plan.radii = given ? job.reconstruct.ball_radii : measured.automatic_radii;
  plan.radii_reason =
      given ? compare_with_spacing(plan.radii, measured.spacing) : measured.radii_reason;
  if (!plan.radii.empty()) plan.halo_width = halo_width(plan.radii);
}

void plan_resources(const ResolvedJob& job, const CountedCloud& cloud, const Partition& measured,
                    JobPlan& plan) {
  plan.peak_memory_bytes = predicted_peak_bytes(job, measured, plan.radii);
  plan.disk_bytes = plan_disk(job, size_of(cloud), raw_work_of(plan)).most_bytes;
  plan.seconds =
      predicted_seconds(job, plan.points, plan.radii, plan.normals, plan.cleaning.options);
}

}  // namespace

JobPlan plan_job(const Job& wanted, Progress& progress, const StopToken& stop) {
  JobPlan plan;
  plan.files = expand_globs(wanted.input.files);
  const ResolvedJob job = resolve(wanted, plan.files);
  const RunControl control{job, progress, stop};
  const CloudInput input = scans_as_input(job, kFinalCut);
  const CountedCloud cloud = count(control, input);
  Partition measured = sample(control, input, cloud);
  measured.schema = cloud.schema;
  plan.points = cloud.points_used;
  plan.bounds = cloud.grid.bounds();
  plan_radii(job, measured, plan);
  plan.cleaning = cleaning_for(job.cleaning, measured);
  plan.normals = normals_of(job, cloud);
  plan_chunks(job, cloud, measured, plan);
  plan_resources(job, cloud, measured, plan);
  if (job.fill.enabled) plan.loops = stored_loops(job, stop);
  return plan;
}

}  // namespace orbweave
