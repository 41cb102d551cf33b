// How long a job takes, from typical rates of one core.
#pragma once

#include <span>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// Seconds of a run from its start, with all its threads on cores of their own, a disk that keeps
/// up, and few holes, shared evenly by `processes`. Points that the job dropped count as well.
double predicted_seconds(const ResolvedJob& job, const Partition& partition,
                         std::span<const double> radii, int processes);

}  // namespace orbweave
