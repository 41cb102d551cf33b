// A hole's patch as a height field over the hole's plane.
// Abdel-Wahab, Hussein, Taha, Gaber: An Enhanced Algorithm for Surface Reconstruction from a Cloud
// of Points, GVIP 2005, section 3.
#pragma once

#include "engine/holes/patch/rim.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// Fits a radial basis function to the heights of the rim and of the sheet around it over the
/// plane of the hole, and covers the inside of the loop with new points at the rim's spacing.
/// FillMethod::kPlane, or kNone with a reason where the loop overlaps itself seen along the hole's
/// normal, the sheet around it is no height field, or the patch would take more than
/// options.max_new_points. Never throws for what the hole is like.
/// The residual is that of the sites: the rim, the sheet beside it, and fewer and fewer vertices
/// further out (plane_sites.h).
HolePatch plane_fill(const HoleProblem& problem, const PatchOptions& options);
/// The same; `rim`: of the problem.
HolePatch plane_fill(const HoleProblem& problem, const Rim& rim, const PatchOptions& options);

}  // namespace orbweave
