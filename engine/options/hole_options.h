// Options of the hole pass from those that a job and the library share.
#pragma once

#include "engine/holes/problem/hole_options.h"
#include "io/surface_options.h"

namespace orbweave {

HoleOptions hole_options(const FillOptions& fill);

}  // namespace orbweave
