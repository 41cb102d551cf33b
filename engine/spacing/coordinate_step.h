// Coordinates that were rounded, to 32-bit floats far from the origin or to few decimals: they come
// in steps.
#pragma once

#include <span>
#include <string>

#include "engine/spacing/spacing_site.h"

namespace orbweave {

/// The distance between neighbouring 32-bit floats at the largest coordinate of an axis whose
/// coordinates are all such floats; of several such axes the largest distance. 0: no axis is. An
/// axis whose coordinates are multiples of something coarser, such as whole metres, was not rounded
/// and does not count. O(n).
double coordinate_step(std::span<const SpacingSite> sites);

/// What is wrong with points that lie `spacing` apart in steps of `step`: "coordinates come in
/// steps of about 0.5, the points lie 0.05 apart: ..."; empty where the steps are fine enough.
std::string objection_to_step(double step, double spacing);

/// The step that coordinates are multiples of, apart from an offset, as those of a LAS file are of
/// its scale and those of a text of its last decimal; of the three axes the smallest. 0: an axis
/// has none, is all one value, or has too few points to tell. O(n log n); of large sites a part is
/// looked at.
double common_step(std::span<const SpacingSite> sites);

/// What is wrong with points that lie `spacing` apart and have a common step; empty where the step
/// is fine enough.
std::string objection_to_common_step(double step, double spacing);
/// The spacing from which on a common step is fine enough.
double spacing_for_step(double common_step);

}  // namespace orbweave
