// How much a patch bends, rim included: which of several patches is the fairest.
// Grinspun, Hirani, Desbrun, Schroeder: Discrete Shells, SCA 2003, section 2 (bending energy).
#pragma once

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// The sum over edges, those of the rim included, of 3 theta^2 e^2 / (A + B): theta the angle
/// between the faces, e the edge's length, A and B the faces' areas. About the integral of the
/// squared curvature; without a unit, and the same at any scale.
double bending_energy(const HoleProblem& problem, const HolePatch& patch);

}  // namespace orbweave
