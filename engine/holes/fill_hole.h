// One hole, one patch: chooses the method and tries the next where one does not do.
// Abdel-Wahab, Hussein, Taha, Gaber: An Enhanced Algorithm for Surface Reconstruction from a Cloud
// of Points, GVIP 2005, section 3. docs/holes.md says what is done otherwise, and why.
#pragma once

#include "engine/holes/hole.h"

namespace orbweave {

/// Fills a hole. A pure function of its arguments; never throws for what the hole is like: a loop
/// that cannot be closed comes back with FillMethod::kNone and a reason.
/// Guarantees for a filled hole: the patch's boundary is the loop, edge by edge and against the
/// sheet's direction; no edge inside is in `forbidden` or used by more than two triangles of the
/// patch; given vertices are used by index only.
HolePatch fill_hole(const HoleProblem& problem, const PatchOptions& options = {});

/// What a patch violates of these guarantees; empty: nothing.
std::string patch_defect(const HoleProblem& problem, const HolePatch& patch);

}  // namespace orbweave
