// The ball radii of a job: as given or chosen, with the reason, and whether they make sense.
#pragma once

#include <string>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"
#include "engine/pipeline/surface/surface_inputs.h"

namespace orbweave {

/// Throws Error (usage) for given radii so large that no ball could be computed in sensible time,
/// (bad input) where none can be chosen.
BallRadii radii_of_job(const ResolvedJob& job, const Partition& partition);

/// "rho = 0.5 is 300 times the point spacing 0.0016"
std::string compare_with_spacing(const std::vector<double>& radii, double spacing);

}  // namespace orbweave
