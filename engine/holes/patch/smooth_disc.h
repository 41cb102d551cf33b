// A disc that spans a loop: refined at the rim's spacing, as smooth as the rim lets it be.
// Liepa: Filling Holes in Meshes, SGP 2003; Botsch, Kobbelt: An Intuitive Framework for Real-Time
// Freeform Modeling, SIGGRAPH 2004 (thin plate).
#pragma once

#include <optional>
#include <string>

#include "engine/holes/patch/direct_fill.h"
#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

// Edge lengths of patches in rim spacings: split above, joined below. Their ratio is more than 2,
// so that halves of a split edge are not joined again.
inline constexpr double kLongestEdge = 1.4;
inline constexpr double kShortestEdge = 0.6;

/// Order 1: a membrane, within the loop's convex hull; order 2: a thin plate tangent to the sheet.
/// Empty where it would need more new points than allowed.
std::optional<PatchMesh> smooth_disc(const HoleProblem& problem, const LoopTriangles& loop,
                                     int order, const PatchOptions& options);

/// The reason of a patch that would need too many.
std::string too_many_points(const PatchOptions& options);

}  // namespace orbweave
