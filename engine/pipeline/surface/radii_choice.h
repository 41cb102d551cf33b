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

/// "ball radius 0.5, 312 times the point spacing 0.0016", or first and last of several; with the
/// unit where it is known:
/// "ball radii 47 mm to 238 mm (5 levels), 1.1 to 5.57 times the point spacing 42.7 mm".
std::string short_radii(const ResolvedJob& job, const Partition& partition,
                        const std::vector<double>& radii);

}  // namespace orbweave
