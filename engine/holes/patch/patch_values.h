// Attributes of a patch's new vertices.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// Means of the corners' values, weighted by the inverse squares of their distances:
/// points.size() rows of problem.channels values. Empty without channels. World coordinates.
std::vector<double> values_from_corners(const HoleProblem& problem, std::span<const Vec3> points);

/// Gives a patch that lacks values those from the corners.
void give_values(const HoleProblem& problem, HolePatch& patch);

/// By a biharmonic interpolant in space of the values at `sites` (vertices of the problem), kept
/// within the range that each channel has at them; from the corners where there is none.
std::vector<double> values_from_sites(const HoleProblem& problem,
                                      std::span<const std::uint32_t> sites,
                                      std::span<const Vec3> points, const PatchOptions& options);

}  // namespace orbweave
