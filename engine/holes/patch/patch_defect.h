// What a finished patch must be, checked without regard to how it was made.
#pragma once

#include <span>
#include <string>

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// What a patch violates of the guarantees of fill_hole(); empty: nothing.
std::string patch_defect(const HoleProblem& problem, const HolePatch& patch);
/// The same; `rim_faces` as Rim::faces.
std::string patch_defect(const HoleProblem& problem, std::span<const Triangle> rim_faces,
                         const HolePatch& patch);

}  // namespace orbweave
