// Patches for holes that no plane can hold: ends of tubes, rims of hemispheres, holes over edges.
// The signed distance around the hole is interpolated in space, and a disc that spans the loop is
// moved onto its zero set. Carr, Beatson, Cherrie, Mitchell, Fright, McCallum, Evans:
// Reconstruction and Representation of 3D Objects with Radial Basis Functions, SIGGRAPH 2001.
#pragma once

#include "engine/holes/patch/crease.h"
#include "engine/holes/patch/direct_fill.h"
#include "engine/holes/patch/rim_piercings.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// A patch, and whether it is known to meet neither the sheet nor itself. It may lack values.
struct ImplicitPatch {
  HolePatch patch;
  bool is_clear = false;
};

/// Patch of the topology of a disc. It starts as a thin plate, refined at the rim's spacing and
/// tangent to the sheet, and is then moved onto the zero set of the interpolant. Where that has no
/// usable zero set near (no normals, no convergence, folded or intersecting patch) the thin plate
/// stands; `reason` says so and `sites` is 0. FillMethod::kNone where more new points than allowed
/// would be needed. No zero set is looked at where the loop's own edges run into the sheet.
/// `sheet`: of the problem's sheet.
HolePatch implicit_fill(const HoleProblem& problem, const LoopTriangles& loop,
                        const PatchOptions& options = {});
ImplicitPatch implicit_fill(const HoleProblem& problem, const LoopTriangles& loop,
                            const BoxTree& sheet, const RimPiercings& piercings,
                            const PatchOptions& options);

/// The membrane over the loop: refined like the others, but as flat as can be. It stays within
/// the loop's convex hull, and so out of the way of sheets that a rounder patch would meet. It
/// lacks values.
HolePatch membrane_fill(const HoleProblem& problem, const LoopTriangles& loop,
                        const PatchOptions& options = {});

/// The membrane with its new vertices in a plane that lies behind the sheet. It rises steeply to
/// those parts of the rim that stand above the plane. It lacks values.
HolePatch recessed_fill(const HoleProblem& problem, const LoopTriangles& loop,
                        const RecessedPlane& plane, const PatchOptions& options = {});

}  // namespace orbweave
