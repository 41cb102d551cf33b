// How long a job takes, from typical rates of one core.
#pragma once

#include <cstdint>
#include <span>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// Seconds of a run from its start, with all its threads on cores of their own, a disk that keeps
/// up, and few holes. `points` are those that were read and can be used, exact duplicates and what
/// cleaning drops among them; `normals` and `cleaning` as they are applied.
double predicted_seconds(const ResolvedJob& job, std::uint64_t points,
                         std::span<const double> radii, const NormalFacts& normals,
                         const CleaningOptions& cleaning);

/// Of a job whose points are cut, shared evenly by `processes`.
double predicted_seconds(const ResolvedJob& job, const Partition& partition,
                         std::span<const double> radii, int processes);

}  // namespace orbweave
