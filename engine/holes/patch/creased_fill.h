// Patches for holes that run across an edge between planes: each plane goes on to the line in which
// it meets the next, and edges of the patch lie on that line.
#pragma once

#include "engine/holes/patch/rim.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// A patch whose parts continue the planes around the hole (planes_at_rim.h). Each part is the
/// membrane over its part of the rim and the edge, with triangles of the rim's spacing.
/// FillMethod::kNone without a reason where the loop has few edges or the surroundings are no such
/// planes, with one where the planes do not meet inside the hole. Precondition: no corner is
/// visited twice.
HolePatch creased_fill(const HoleProblem& problem, const PatchOptions& options = {});
/// The same; `rim`: of the problem.
HolePatch creased_fill(const HoleProblem& problem, const Rim& rim, const PatchOptions& options);

}  // namespace orbweave
