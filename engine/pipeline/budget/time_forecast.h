// How long the stages of a job take, from typical rates of one core.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"
#include "io/report/progress.h"

namespace orbweave {

/// How much work there is, as far as it is known.
struct JobSize {
  std::uint64_t points = 0;            ///< usable ones of the scans
  std::uint64_t kept_points = 0;       ///< of these, by cleaning
  std::size_t radii = 0;               ///< ball radii; 0: not known
  std::optional<std::uint64_t> loops;  ///< boundary loops to be filled
  int processes = 1;
  double halo_work = 1.0;  ///< points of all chunks with their halos over the points
};

/// The stages of the job in their order, each with its seconds, with all threads on cores of their
/// own and a disk that keeps up. Stages that the job may run are among them.
std::vector<ExpectedStage> expected_stages(const ResolvedJob& job, const JobSize& size);

/// The size of a job whose points are cut. Points that stages of the job dropped count as well.
JobSize size_of_job(const Partition& partition, std::span<const double> radii, int processes);

double sum_of_seconds(std::span<const ExpectedStage> stages);

}  // namespace orbweave
