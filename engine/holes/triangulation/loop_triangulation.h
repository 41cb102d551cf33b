// Triangulation of a loop in space without new points.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/holes/triangulation/corner_triangle.h"
#include "engine/holes/triangulation/loop_in_space.h"

namespace orbweave {

/// The triangulation of the loop of the least largest dihedral angle (rim included where there are
/// normals), then of the least area; triangles without area come last. Exactly so up to
/// kLeastBendCorners corners; up to `exact_corners` as Liepa does it, O(n^3): the best triangle at
/// an edge is chosen without the one across it. Of larger loops ears are cut first, those of the
/// least dihedral and corner angle before others and those that would cover another corner last,
/// until this number of corners is left.
/// n - 2 triangles. Chords are not used that are `forbidden` (pairs of mesh vertices), join corners
/// of one vertex, or repeat a rim edge or another chord between the same vertices. Empty where that
/// is impossible (or was not found, where vertices are visited several times).
/// Barequet, Sharir: Filling Gaps in the Boundary of a Polyhedron, CAGD 1995; Liepa: Filling Holes
/// in Meshes, SGP 2003, section 3.
std::vector<CornerTriangle> triangulate_loop(const LoopInSpace& loop,
                                             std::uint32_t exact_corners = 160);

}  // namespace orbweave
