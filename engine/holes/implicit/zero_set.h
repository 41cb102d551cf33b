// A disc on the zero set of the signed distance that is interpolated around a hole.
#pragma once

#include <optional>
#include <string>

#include "engine/holes/implicit/surface_sites.h"
#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/patch/rim.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

struct ZeroSetPatch {
  std::optional<HolePatch> patch;  ///< without values
  std::string fault;               ///< why there is none
};

/// Moves a disc that spans the loop onto the zero set of the interpolant of `distances`; refines
/// it meanwhile at the rim's spacing.
ZeroSetPatch patch_on_zero_set(const HoleProblem& problem, const Rim& rim,
                               const SignedDistances& distances, RbfKernel kernel, PatchMesh disc,
                               const PatchOptions& options);

}  // namespace orbweave
