// Whether the trajectory of a job belongs to its scans.
#pragma once

#include "engine/pipeline/points/cloud_input.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Throws Error (bad input) where more than one in a hundred points were measured at times that the
/// trajectory does not cover, or where it lies so far from the points that its coordinates are
/// others. Nothing where the job has no trajectory, or asks for no scanner.
void require_fitting_trajectory(const RunControl& control, const CountedCloud& cloud);

}  // namespace orbweave
