// What a run would do, from the counting pass, a sampling pass and typical rates.
#include <algorithm>

#include "engine/ball_pivoting/automatic_radii.h"
#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/partition_stage.h"
#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/radii_choice.h"
#include "io/glob.h"

namespace orbweave {
namespace {

/// Points per second and core of the whole pipeline on a clean surface with one radius, for
/// orientation only; every further radius costs about a quarter more.
constexpr double kPointsPerSecond = 400'000.0;
constexpr double kFurtherRadius = 0.25;

std::uint64_t disk_bytes(const CountedCloud& cloud) {
  const std::uint64_t normal = 3 * size_of(cloud.schema.normal_type);
  const std::uint64_t point = sizeof(Vec3) + normal + cloud.schema.attribute_bytes();
  const std::uint64_t triangles = 2 * (3 * sizeof(std::uint64_t));
  const std::uint64_t output = point + 2 * (1 + 3 * sizeof(std::uint32_t));
  const std::uint64_t all = point * cloud.points_used;
  const std::uint64_t spill = all > cloud.memory.bin_buffer_bytes ? all : 0;
  return spill + cloud.points_used * (point + triangles + 1 + output);
}

/// The second pass of a run, for the radii alone.
RadiiChoice sample_radii(const InputContext& context, const CountedCloud& cloud) {
  SpacingSampler sampler(cloud.octree.root(), cloud.grid);
  const auto source = open_input(context);
  stream_points(*source, {.threads = context.threads(), .stop = &context.stop}, {},
                [&](StreamBatch& batch) { sampler.add(batch.points.positions); });
  return sampler.choose(std::max(1, context.job.reconstruct.levels));
}

}  // namespace

JobPlan plan_job(const Job& job, Progress& progress, const StopToken& stop) {
  JobPlan plan;
  plan.files = expand_globs(job.input.files);
  const InputContext context{job, plan.files, progress, stop};
  progress.begin_stage("count", 0, "points");
  const CountedCloud cloud = count_points(context);
  progress.end_stage();
  progress.begin_stage("sample", 0, "points");
  const RadiiChoice choice = sample_radii(context, cloud);
  progress.end_stage();
  const bool given = !job.reconstruct.ball_radii.empty();
  plan.radii = given ? job.reconstruct.ball_radii : choice.radii;
  plan.radii_reason = given ? compare_with_spacing(plan.radii, choice.spacing) : choice.reason;
  if (!plan.radii.empty()) plan.halo_width = halo_width(plan.radii);
  plan.points = cloud.points_used;
  plan.bounds = cloud.grid.bounds();
  plan.chunks = cloud.octree.chunks().size();
  plan.chunk_points = cloud.memory.chunk_points;
  for (const Chunk& chunk : cloud.octree.chunks()) {
    plan.largest_chunk_points = std::max(plan.largest_chunk_points, chunk.points);
  }
  const std::size_t chunk_bytes =
      std::max<std::size_t>(1, plan.largest_chunk_points * MemoryCosts::kReconstructBytes);
  const auto affordable = cloud.memory.chunks_in_flight_bytes / chunk_bytes;
  plan.chunks_in_flight = static_cast<int>(
      std::clamp<std::size_t>(affordable, 1, static_cast<std::size_t>(context.threads()) + 1));
  const std::size_t in_flight =
      std::min<std::size_t>(static_cast<std::size_t>(plan.chunks_in_flight) * chunk_bytes,
                            plan.points * MemoryCosts::kReconstructBytes);
  const std::size_t bins = std::min<std::size_t>(
      cloud.memory.bin_buffer_bytes, plan.points * MemoryCosts::sort_bytes(cloud.schema));
  plan.peak_memory_bytes = MemoryCosts::kBaseBytes + std::max(in_flight, bins);
  plan.disk_bytes = disk_bytes(cloud);
  const double levels = 1.0 + kFurtherRadius * static_cast<double>(plan.radii.size() - 1);
  plan.seconds = static_cast<double>(plan.points) * levels / (kPointsPerSecond * context.threads());
  return plan;
}

}  // namespace orbweave
