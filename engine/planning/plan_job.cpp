#include "engine/planning/plan_job.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/normals/normal_side.h"
#include "engine/pipeline/budget/disk_plan.h"
#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/budget/time_forecast.h"
#include "engine/pipeline/output/export_stage.h"
#include "engine/pipeline/output/map_tiles.h"
#include "engine/pipeline/output/mesh_name.h"
#include "engine/pipeline/output/power_crust_files.h"
#include "engine/pipeline/output/simplify_stage.h"
#include "engine/pipeline/output/tile_export.h"
#include "engine/pipeline/output/tileset_stage.h"
#include "engine/pipeline/points/cleaning_stage.h"
#include "engine/pipeline/points/cloud_measure.h"
#include "engine/pipeline/points/count_stage.h"
#include "engine/pipeline/points/missed_scans.h"
#include "engine/pipeline/points/missing_poses.h"
#include "engine/pipeline/points/point_doubts.h"
#include "engine/pipeline/points/scan_input.h"
#include "engine/pipeline/stage/cleaning_rule.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/stage/scan_units.h"
#include "engine/pipeline/stage/stage_begin.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "engine/pipeline/surface/hole_stage.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/pipeline/surface/radii_choice.h"
#include "engine/pipeline/surface/stitch_stage.h"
#include "engine/pipeline/surface/used_vertices.h"
#include "engine/planning/trial.h"
#include "io/error.h"
#include "io/system/glob.h"
#include "io/system/memory_limit.h"
#include "io/system/process_times.h"

namespace orbweave {
namespace {

/// Seconds on the clock that the passes over the files took.
struct PassSeconds {
  double count = 0.0;
  double sample = 0.0;
};

CountedCloud count(const RunControl& control, const CloudInput& input, PassSeconds& seconds) {
  const double begin = steady_seconds();
  control.progress.begin_stage(name_of(input.stages.count), 0, "points");
  CountedCloud cloud = count_points(control, input);
  control.progress.end_stage();
  seconds.count = steady_seconds() - begin;
  return cloud;
}

/// What the second pass of a run measures, and samples for the trial.
struct Sampled {
  Partition measured;
  std::vector<PointCloud> samples;
  std::vector<std::string> doubts;
};

Sampled sample(const RunControl& control, const CloudInput& input, const CountedCloud& cloud,
               PassSeconds& seconds) {
  const double begin = steady_seconds();
  control.progress.begin_stage("sample", cloud.points_used, "points");
  SpacingSampler spacings(cloud.octree.root(), cloud.grid);
  if (cloud.extents.all().size() > 1) spacings.collect_scans();
  TrialSamples samples(cloud.octree.root(), cloud.grid);
  const auto source = input.open(nullptr);
  stream_points(*source,
                {.threads = control.threads(), .stop = &control.stop, .filter = &cloud.filter}, {},
                [&](StreamBatch& batch) {
                  spacings.add(batch.points.positions, cloud.extents.index_of(batch.scan));
                  samples.add(batch.points);
                  control.progress.advance(batch.points.size());
                });
  std::vector<std::string> doubts = objections_to_surfaces(control.job, cloud.extents, spacings,
                                                           cloud.meters_per_unit, control.stop);
  Partition measured = measure(input, spacings, control);
  control.progress.end_stage();
  seconds.sample = steady_seconds() - begin;
  return {std::move(measured), samples.take(), std::move(doubts)};
}

NormalFacts normals_of(const ResolvedJob& job, const CountedCloud& cloud) {
  NormalFacts normals;
  normals.source = NormalSource::kFile;
  if (!job.estimates_normals) return normals;
  const bool are_poles = job.normals.source == NormalSource::kPoles;
  normals.source = are_poles ? NormalSource::kPoles : NormalSource::kEstimate;
  normals.orientation = job.orientation_rule(cloud.points_without_view);
  return normals;
}

/// The passes over raw points, as far as the plan has found them out.
RawWork raw_work_of(const JobPlan& plan) {
  const bool estimates = plan.normals.source != NormalSource::kFile;
  const bool propagates = is_propagated(plan.normals.orientation);
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
                                const UsedVertices& used, const StopToken& stop) {
  VertexRanks ranks(used);
  std::vector<HoleFacts> loops = list_loops(stitched.boundary, fill, stop);
  for (HoleFacts& loop : loops) loop.first_vertex = value_of(ranks.of(loop.first_vertex));
  return loops;
}

/// The loops of the mesh that an earlier run of the same job left in its work directory.
std::optional<std::vector<HoleFacts>> stored_loops(const ResolvedJob& job, const StopToken& stop) {
  try {
    const std::unique_ptr<const ChunkStore> left = ChunkStore::look(work_dir_of(job));
    if (left == nullptr) return std::nullopt;
    const ChunkStore& store = *left;
    if (!holds_points(store, kPointsStage, points_key(job))) return std::nullopt;
    const std::optional<Partition> partition = stored_partition(store);
    if (!partition) return std::nullopt;
    const BallRadii radii = radii_of_job(job, *partition);
    const SurfaceInputs inputs{*partition, radii};
    if (!holds_a_mesh(job, store, inputs)) return std::nullopt;
    std::optional<Stitched> stored = stored_stitch(inputs, job, store);
    const Stitched stitched = stored ? std::move(*stored) : stitch_chunks(inputs, job, store, stop);
    const UsedVertices used(store, *partition, stitched.used, {});
    return loops_of(stitched, job.fill, used, stop);
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::kInterrupted) throw;
    return std::nullopt;  // a run removes it, or it is damaged: a plan can do without
  }
}

/// What a run refuses before any point is read.
void check_options(const Job& job) {
  require_method(job);
  check_power_crust_files(job);
  check_tile_size(job);
  if (job.output.mesh.empty()) return;
  if (job.output.tiles) check_tile_format(job.output);
  check_mesh_name(job.output);
  check_tileset(job);
  check_simplification(job);
  if (job.output.tiles) check_tile_place(job.output);
}

/// What a run refuses when it knows the points. Those that cleaning leaves are the run's alone.
void check_mesh_file(const ResolvedJob& job, const Partition& measured, JobPlan& plan) {
  if (job.output.mesh.empty() || cleans(plan.cleaning.options)) return;
  PointSchema vertices = vertex_schema(job.output, measured);
  if (job.estimates_normals && job.output.attributes) vertices.has_normals = true;
  check_format_holds(job.output, plan.points, vertices);
  const std::string objection = check_output_origin(job, mesh_origin(job.output, measured));
  if (!objection.empty()) plan.doubts.push_back(objection);
  check_simplified_origin(job, measured);
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
  if (is_in_core(job.reconstruct.method)) {
    plan.radii_reason = "not used by " + method_name(job);
    return;
  }
  const bool given = !job.reconstruct.ball_radii.empty();
  // The spacing of a cleaned cloud is another one.
  if (given && !cleans(plan.cleaning.options)) radii_of_job(job, measured);
  plan.radii = given ? job.reconstruct.ball_radii : measured.automatic_radii;
  plan.radii_note = short_radii(job, measured, plan.radii);
  plan.radii_reason = given ? plan.radii_note : measured.radii_reason;
  if (!plan.radii.empty()) plan.halo_width = halo_width(plan.radii);
}

/// As the run treats its points. Radii of a thinned cloud are not those of the scans.
TrialOptions trial_options(const ResolvedJob& job, const Partition& measured, const JobPlan& plan,
                           const StopToken& stop) {
  const CleaningOptions& cleaning = plan.cleaning.options;
  const bool thins = cleaning.thin_to_spacing > 0.0 || cleaning.merge_tolerance > 0.0;
  TrialOptions options;
  options.cleaning = cleaning;
  options.normals = job.normals;
  options.normals.orientation = plan.normals.orientation;
  options.estimates_normals = plan.normals.source != NormalSource::kFile;
  options.estimate = estimate_options(job, measured, cleaning);
  options.reach_of_outliers = measured.normal_radius;
  const bool given = !job.reconstruct.ball_radii.empty();
  if (!thins || given) options.ball_radii = plan.radii;
  if (job.reconstruct.levels == 0 && !given && !plan.radii.empty())
    options.least_last_radius = plan.radii.back();
  options.fill = job.fill;
  options.threads = job.threads();
  options.stop = &stop;
  return options;
}

/// Seconds of a run: passes over the files as the plan took them, the trial's work for all points
/// and all threads, and what grows with the points alone.
double seconds_of_run(const ResolvedJob& job, const JobPlan& plan, const TrialResult& trial,
                      const PassSeconds& passes) {
  // Calibrated on the scans of docs/results/scans.md, as seconds per point.
  constexpr double kCutAgain = 0.35e-6;  // count, bin, measure and sort of cleaned points
  constexpr double kSort = 0.06e-6;      // of the points as they come
  constexpr double kWritten = 0.42e-6;   // stitch, trace and export
  constexpr double kByMap = 0.4e-6;      // what tiles on a map grid take more
  constexpr double kCompressed = 1.3e-6;
  constexpr double kStage = 0.005;  // of a stage, whatever its points: keys, files, flushes
  // Time per point in a chunk over time per point in a small sample: the sample has more border.
  constexpr double kOfSample = 0.79;
  const auto points = static_cast<double>(plan.points);
  const double sampled = static_cast<double>(std::max<std::uint64_t>(trial.points, 1));
  const double kept = points * static_cast<double>(trial.points_kept) / sampled;
  const MethodCosts costs = costs_of(job.reconstruct.method);
  double seconds =
      passes.count + passes.sample + kSort * points + kWritten * kept * costs.vertices_per_point;
  seconds += kStage * static_cast<double>(expected_stages(job, {}).size());
  if (job.needs_cleaning_or_normals()) seconds += kCutAgain * kept;
  if (job.output.tile_size > 0.0) seconds += kByMap * kept * costs.vertices_per_point;
  if (job.run.compress) seconds += kCompressed * points / job.threads();
  const bool in_chunks = is_cocone(job.reconstruct.method) && plan.chunks > 1;
  seconds += 1e-6 * costs.microseconds_per_point * kept *
             (in_chunks ? kCoconeBoxesPerChunk / job.threads() : 1.0);
  seconds += 1e-6 * costs_of(job.normals.source).microseconds_per_point * points;
  return seconds + kOfSample * points * trial.cpu_seconds / sampled / job.threads();
}

/// Reconstructs samples of the scan for the time that it takes.
double planned_seconds(const RunControl& control, const Partition& measured,
                       std::vector<PointCloud> samples, const PassSeconds& passes,
                       const JobPlan& plan) {
  const ResolvedJob& job = control.job;
  const std::size_t count = samples.size();
  control.progress.begin_stage("trial", count, "samples");
  const TrialResult trial =
      run_trial(std::move(samples), trial_options(job, measured, plan, control.stop));
  control.progress.advance(count);
  control.progress.end_stage();
  return seconds_of_run(job, plan, trial, passes);
}

void plan_resources(const ResolvedJob& job, const CountedCloud& cloud, const Partition& measured,
                    JobPlan& plan) {
  plan.peak_memory_bytes = predicted_peak_bytes(job, measured, plan.radii);
  const std::string objection =
      objection_to_peak(job, plan.peak_memory_bytes, memory_limit_bytes());
  if (!objection.empty()) plan.doubts.push_back(objection);
  plan.disk_bytes = plan_disk(job, size_of(cloud), raw_work_of(plan)).all_bytes();
}

}  // namespace

JobPlan plan_job(const Job& wanted, Progress& progress, const StopToken& stop) {
  check_options(wanted);
  JobPlan plan;
  plan.files = expand_globs(wanted.input.files);
  const ResolvedJob job = resolve(wanted, plan.files);
  check_viewpoint(job);
  const RunControl control{job, progress, stop};
  const CloudInput input = scans_as_input(control, kFinalCut);
  PassSeconds passes;
  const CountedCloud cloud = count(control, input, passes);
  require_a_triangle(job.files.front(), cloud.points_used, cloud.points_read, cloud.dropped);
  Sampled sampled = sample(control, input, cloud, passes);
  Partition& measured = sampled.measured;
  measured.bounds = cloud.grid.bounds();
  measured.schema = cloud.schema;
  measured.meters_per_unit = cloud.meters_per_unit;
  measured.coordinate_system = cloud.coordinate_system;
  plan.points = cloud.points_used;
  plan.points_read = cloud.points_read;
  plan.points_dropped = cloud.dropped;
  plan.bounds = measured.bounds;
  plan.cleaning = cleaning_for(job.cleaning, measured);
  check_side(job, cloud.points_without_view);
  check_smoothing(job, plan.cleaning);
  plan_radii(job, measured, plan);
  check_mesh_file(job, measured, plan);
  const double unit = meters_per_unit(job, measured);
  if (measured.layers.measured > 0)
    plan.noise_note = job.cleaning.automatic ? short_reason(measured.layers, unit)
                                             : short_noise(measured.layers, unit);
  const std::string steps = objection_to_steps(job, measured, plan.cleaning.options);
  if (!steps.empty()) plan.doubts.push_back(steps);
  plan.doubts.insert(plan.doubts.end(), cloud.doubts.begin(), cloud.doubts.end());
  plan.doubts.insert(plan.doubts.end(), sampled.doubts.begin(), sampled.doubts.end());
  for (const std::string& objection :
       {objection_to_missed_scans(job), objection_to_missing_poses(job),
        objection_to_chunks(job, plan.points)})
    if (!objection.empty()) plan.doubts.push_back(objection);
  measured.normals = plan.normals = normals_of(job, cloud);
  for (std::string& objection : objections_to_points(job, measured))
    plan.doubts.push_back(std::move(objection));
  plan_chunks(job, cloud, measured, plan);
  plan_resources(job, cloud, measured, plan);
  plan.seconds = planned_seconds(control, measured, std::move(sampled.samples), passes, plan);
  if (job.fill.enabled) plan.loops = stored_loops(job, stop);
  return plan;
}

}  // namespace orbweave
