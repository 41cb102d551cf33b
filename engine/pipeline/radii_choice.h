// The ball radii of a job: as given or chosen, with the reason, and whether they make sense.
#pragma once

#include <string>
#include <vector>

#include "engine/pipeline/job_context.h"
#include "engine/pipeline/partition_stage.h"

namespace orbweave {

/// Fills the report's radii and their reason. Throws Error (usage) for given radii so large that
/// no ball could be computed in sensible time, (bad input) where none can be chosen.
std::vector<double> radii_of_job(JobContext& context, const Partition& partition);

/// "rho = 0.5 is 300 times the point spacing 0.0016"
std::string compare_with_spacing(const std::vector<double>& radii, double spacing);

}  // namespace orbweave
