// How long a job takes, from typical rates of one core.
#pragma once

#include <cstdint>
#include <span>

#include "engine/pipeline/partition_stage.h"

namespace orbweave {

/// Seconds of a run from its start, with all its threads on cores of their own, a disk that keeps
/// up, and few holes. `points` are those that were read and can be used, exact duplicates and what
/// clean-up drops among them; `normals` and `clean_up` as they are applied.
double predicted_seconds(const InputContext& context, std::uint64_t points,
                         std::span<const double> radii, const NormalFacts& normals,
                         const PrepareOptions& clean_up);

/// The same of a job whose points are cut, shared evenly by its team.
double predicted_seconds(const JobContext& context, const Partition& partition,
                         std::span<const double> radii);

}  // namespace orbweave
