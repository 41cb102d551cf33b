// Holes of small meshes as the hole pass gathers them, and what a patch makes of the mesh.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "engine/holes/problem/hole.h"
#include "io/triangle_mesh.h"

namespace orbweave::test {

/// A mesh without the triangles for which `gone(centre)` holds.
TriangleMesh without(TriangleMesh mesh, const std::function<bool(Vec3)>& gone);
TriangleMesh transformed(TriangleMesh mesh, double scale, Vec3 offset);
/// A tube of radius 1 around z, from z = 0 down, closed at the bottom; rows as far apart as the
/// vertices along a ring.
TriangleMesh open_tube(std::size_t around, std::size_t rows);
/// A grid of side by side quads over [-1, 1]^2, at these heights.
TriangleMesh height_field(std::size_t side, const std::function<double(double, double)>& height);

/// The loops in canonical order, borders too.
std::vector<HoleProblem> problems_of(const TriangleMesh& mesh, double radius_factor = 2.0);
/// The only hole of a mesh.
HoleProblem only_problem_of(const TriangleMesh& mesh, double radius_factor = 2.0);
/// The hole of an open sheet, not its border: of two loops that of fewer edges.
HoleProblem inner_problem_of(const TriangleMesh& mesh);
/// Gives each vertex the values of its place.
void set_values(HoleProblem& problem, const std::function<std::vector<double>(Vec3)>& values_at);
/// The gathered sheet with the patch.
TriangleMesh pasted(const HoleProblem& problem, const HolePatch& patch);

}  // namespace orbweave::test
