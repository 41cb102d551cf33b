// What is odd about the points of a job, once they are counted: a run warns of it, and a plan has
// it in doubt.
#pragma once

#include <string>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// A sentence each: a spacing that no scanner has, a coordinate system that does not fit, degrees
/// beside heights, a setting that decides nothing. Of the partition, the spacing, bounds,
/// coordinate system, unit and the source of the normals are looked at.
std::vector<std::string> objections_to_points(const ResolvedJob& job, const Partition& partition);

}  // namespace orbweave
