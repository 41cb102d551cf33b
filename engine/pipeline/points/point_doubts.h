// What is odd about the points of a job, once they are counted: a run warns of it, and a plan has
// it in doubt.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// A sentence each: a spacing that no scanner has, a coordinate system that does not fit, degrees
/// beside heights, a setting that decides nothing. Of the partition, the spacing, bounds,
/// coordinate system, unit and the source of the normals are looked at.
std::vector<std::string> objections_to_points(const ResolvedJob& job, const Partition& partition);

/// Of the coordinates of the scans as they came: they lie in steps that are coarse beside the
/// spacing, and `cleaning` does not thin them to a larger one. Empty: they do not.
std::string objection_to_steps(const ResolvedJob& job, const Partition& scans,
                               const CleaningOptions& cleaning);

/// What to say of a number of points per chunk that makes so many chunks that most of the work is
/// done on their halos; empty otherwise. `points`: of the whole cloud.
std::string objection_to_chunks(const ResolvedJob& job, std::uint64_t points);

}  // namespace orbweave
