#include "engine/pipeline/points/cloud_measure.h"

#include <algorithm>
#include <vector>

#include "engine/ball_pivoting/halo_width.h"
#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/points/count_stage.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/spacing/coordinate_decades.h"
#include "engine/spacing/coordinate_step.h"
#include "engine/spacing/normal_radius.h"

namespace orbweave {
namespace {

/// Points of a chunk, so many that its halo costs little on an even surface.
std::uint64_t chunk_points(const ResolvedJob& job, const CountedCloud& cloud,
                           const Partition& partition) {
  const bool expected = !job.reconstruct.ball_radii.empty() || job.reconstruct.levels != 0;
  if (expected || partition.automatic_radii.empty()) return cloud.memory.chunk_points;
  const double points_per_area = 1.0 / (partition.spacing * partition.spacing);
  const MemoryPlan plan = job.memory_plan(
      cloud.points_used, cloud.schema,
      worthwhile_points(partition.automatic_radii, points_per_area, cloud.points_used));
  return std::max(plan.chunk_points, cloud.memory.chunk_points);
}

/// No less than `chunk_points`, which were planned for.
ChunkRoom room_of(const ResolvedJob& job, const CountedCloud& cloud, std::uint64_t chunk_points) {
  // A tenth is left for points that are counted at the middle of a place outside the halo.
  const std::uint64_t with_halo = most_points_with_halo(job) / 10 * 9;
  // Sorting takes half of the memory; a fifth of that is left for chunks that hold more than
  // others.
  const std::uint64_t sorted = cloud.memory.chunks_in_flight_bytes / 5 * 2;
  const std::uint64_t points = std::min(with_halo, sorted / MemoryCosts::sort_bytes(cloud.schema));
  return {std::max(points, chunk_points), with_halo};
}

}  // namespace

Octree final_octree(const ResolvedJob& job, const CountedCloud& cloud, const Partition& partition) {
  if (is_in_core(job.reconstruct.method)) return cloud.octree;
  const std::uint64_t points = chunk_points(job, cloud, partition);
  const std::vector<double>& radii =
      job.reconstruct.ball_radii.empty() ? partition.automatic_radii : job.reconstruct.ball_radii;
  if (!radii.empty() && !cloud.places.empty()) {
    return without_needless_halos(cloud.places, cloud.octree, halo_width(radii), points,
                                  room_of(job, cloud, points));
  }
  if (points <= cloud.memory.chunk_points) return cloud.octree;
  return coarsened(cloud.octree, points);
}

Partition measure(const CloudInput& input, SpacingSampler& sampler, const RunControl& control) {
  if (input.are_scans) require_few_decades(sampler.sites(), control.job.files.front());
  sampler.merge_duplicates(&control.stop);
  const SearchedSites sites(sampler.sites(), &control.stop);
  const int levels = control.job.reconstruct.levels;
  const bool for_normals = input.are_scans && control.job.needs_cleaning_or_normals();
  const auto neighbors = static_cast<std::size_t>(control.job.normals.neighbors);
  const SampledNeighbors sample(sites, std::max(neighbors_for_radii(), for_normals ? neighbors : 0),
                                &control.stop);
  const RadiiChoice choice = choose_radii(sample, sampler.cloud_points(), levels, &control.stop);
  Partition measured;
  measured.spacing = choice.spacing;
  measured.automatic_radii = choice.radii;
  measured.radii_reason = choice.reason;
  measured.spacing_by_area = choice.spacing_by_area;
  measured.sparse_offset = choice.sparse_offset;
  measured.line_neighbors = choice.line_neighbors;
  if (!input.are_scans) return measured;
  measured.coordinate_step = coordinate_step(sites.all());
  measured.common_step = common_step(sites.all());
  measured.layers = measure_layers(sites, &control.stop);
  if (!for_normals) return measured;
  measured.normal_radius =
      normal_radius(sites, sample, std::max(neighbors, choice.line_neighbors), &control.stop);
  return measured;
}

}  // namespace orbweave
