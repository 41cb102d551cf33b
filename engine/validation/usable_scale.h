// Coordinates that can be computed with.
#pragma once

#include <string>

#include "io/box.h"

namespace orbweave {

/// Throws Error (bad input) where squares of squares of lengths are no numbers: for a coordinate
/// beyond 1e75 and for an extent below 1e-75 that is not 0. `bounds`: of the finite points; `what`:
/// "cloud" or "mesh".
void require_usable_scale(const std::string& file, const std::string& what, const Box& bounds);

/// What require_usable_scale() would say of an extent that is too small, in a few words; empty:
/// nothing. Single coordinates that are too large are strays.
std::string objection_to_scale(const Box& bounds);

}  // namespace orbweave
