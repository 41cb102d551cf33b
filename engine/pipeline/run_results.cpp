#include "engine/pipeline/run_results.h"

#include <algorithm>
#include <utility>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/stage/method_costs.h"

namespace orbweave {
namespace {

std::uint64_t largest_chunk_points(const Partition& partition) {
  std::uint64_t largest = 0;
  for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk)
    largest = std::max(largest, partition.points_in(chunk));
  return largest;
}

void describe_partition(Partition partition, RunReport& report) {
  report.chunks = partition.octree.chunks().size();
  report.largest_chunk_points = largest_chunk_points(partition);
  report.points_read = partition.points_read;
  report.points_dropped = std::move(partition.dropped);
  report.cleaning = std::move(partition.cleaning);
  report.normals = partition.normals;
  report.coordinate_system = std::move(partition.coordinate_system);
  report.meters_per_unit = partition.meters_per_unit;
  report.bounds = partition.bounds;
}

}  // namespace

RunReport report_of_job(const ResolvedJob& job, const std::vector<std::string>& command,
                        int processes) {
  RunReport report;
  report.version = ORBWEAVE_VERSION;
  report.command = command;
  report.options = job;
  report.files = job.files;
  report.ranks = processes;
  return report;
}

RunReport report_of(const StageRunner& runner, const std::vector<std::string>& command,
                    RunResults results, const ResourceFacts& measured) {
  RunReport report = report_of_job(runner.job, command, runner.communicator.size());
  report.trusted = trusted_files(runner.job);
  if (is_in_core(runner.job.reconstruct.method)) results.radii.values.clear();
  if (!results.radii.values.empty()) report.halo_width = halo_width(results.radii.values);
  describe_partition(std::move(results.partition), report);
  report.origin = results.origin;
  report.points_unused = results.points_unused;
  report.pieces_removed = results.pieces_removed;
  report.triangles_removed = results.triangles_removed;
  report.radii = std::move(results.radii.values);
  report.radii_reason = std::move(results.radii.reason);
  report.conflicts_lost = results.conflicts_lost;
  report.voronoi = results.voronoi;
  report.mesh = std::move(results.mesh);
  report.holes = std::move(results.holes);
  report.stages = runner.measured;
  report.peak_memory_bytes = measured.peak_memory_bytes;
  report.predicted = results.predicted;
  report.measured = measured;
  report.notes = runner.notes;
  report.warnings = runner.warnings;
  return report;
}

}  // namespace orbweave
