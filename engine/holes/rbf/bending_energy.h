// How much a patch bends, rim included: which of several patches is the fairest.
// Grinspun, Hirani, Desbrun, Schroeder: Discrete Shells, SCA 2003, section 2 (bending energy).
#pragma once

#include <span>
#include <vector>

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// The sum over edges, those of the rim included, of 3 theta^2 e^2 / (A + B): theta the angle
/// between the faces, e the edge's length, A and B the faces' areas. About the integral of the
/// squared curvature; without a unit, and the same at any scale.
double bending_energy(const HoleProblem& problem, const HolePatch& patch);

/// The same, of several patches of a problem; `rim_faces` as faces_at_rim.
double bending_energy(const HoleProblem& problem, std::span<const Triangle> rim_faces,
                      const HolePatch& patch);

/// The sheet's triangles that have two vertices on the rim at least.
std::vector<Triangle> faces_at_rim(const HoleProblem& problem);

}  // namespace orbweave
