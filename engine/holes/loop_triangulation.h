// Triangulation of a loop in space without new points.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/plane_triangulation.h"
#include "io/vec3.h"

namespace orbweave {

/// Triangulation of a loop in space without new points, of the least largest dihedral angle
/// (rim included where `rim_normals`, one per edge, is not empty), then of the least area; O(n^3)
/// up to `exact_corners` corners, larger loops are closed by cutting ears of the least angle.
/// Chords in `forbidden` (pairs of corners as vertices) are not used. Empty where that is
/// impossible.
/// Barequet, Sharir: Filling Gaps in the Boundary of a Polyhedron, CAGD 1995; Liepa: Filling Holes
/// in Meshes, SGP 2003.
struct LoopInSpace {
  std::span<const Vec3> corners;            ///< positions along the loop
  std::span<const std::uint32_t> vertices;  ///< which mesh vertex each corner is
  std::span<const Vec3> rim_normals;        ///< of the face behind edge (i, i + 1); or empty
  std::span<const std::array<std::uint32_t, 2>> forbidden;  ///< mesh vertices, sorted
};
std::vector<CornerTriangle> triangulate_loop(const LoopInSpace& loop,
                                             std::uint32_t exact_corners = 160);

}  // namespace orbweave
