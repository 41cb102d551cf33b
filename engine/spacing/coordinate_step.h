// Coordinates that were rounded to 32-bit floats far from the origin: they come in steps.
#pragma once

#include <span>
#include <string>

#include "engine/spacing/spacing_site.h"

namespace orbweave {

/// The last place of a 32-bit float at the largest coordinate of the sites' points, of the axis
/// where that is widest, and where all coordinates are such floats. 0: there is no such axis. An
/// axis whose coordinates keep a wider distance from each other than that, such as a grid of whole
/// metres, was not rounded. O(n).
double coordinate_step(std::span<const SpacingSite> sites);

/// What is wrong with points that lie `spacing` apart in steps of `step`: "coordinates come in
/// steps of about 0.5, the points lie 0.05 apart: ..."; empty where the steps are fine enough.
std::string objection_to_step(double step, double spacing);

}  // namespace orbweave
