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

/// "ball radius 0.5, 312 times the point spacing 0.0016", or first and last of several:
/// "ball radii 0.047 to 0.238 (5 levels), 1.1 to 5.57 times the point spacing 0.0427".
/// `meters_per_unit`: as for readable_length.
std::string compare_with_spacing(const std::vector<double>& radii, double spacing,
                                 double meters_per_unit = 0.0);

}  // namespace orbweave
