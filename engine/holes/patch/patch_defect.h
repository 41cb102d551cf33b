// What a finished patch must be, checked without regard to how it was made.
#pragma once

#include <string>

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// What a patch violates of the guarantees of fill_hole(); empty: nothing.
std::string patch_defect(const HoleProblem& problem, const HolePatch& patch);

}  // namespace orbweave
