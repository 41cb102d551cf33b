// Small meshes with holes that tests make themselves.
#pragma once

#include <cstddef>
#include <functional>

#include "io/triangle_mesh.h"

namespace orbweave::test {

/// Vertices (u, v) of a grid of `columns` x `rows` quads, each cut in two; counter-clockwise in
/// (u, v), which run from 0 to 1. `wrapped`: the last column joins the first.
TriangleMesh grid_mesh(std::size_t columns, std::size_t rows, bool wrapped,
                       const std::function<Vec3(double, double)>& place);
/// Unit square in z = 0, normals up, `side` quads along each side.
TriangleMesh square_mesh(std::size_t side);
/// Torus around z with radii 1 and 0.4, closed, about the given number of vertices.
TriangleMesh torus_mesh(std::size_t vertices);
/// Unit sphere, closed: a subdivided octahedron with 4^levels * 8 triangles.
TriangleMesh sphere_mesh(int levels);
/// The surface of the unit cube, `side` quads along each edge.
TriangleMesh cube_mesh(std::size_t side);

/// Drops the triangles for which `gone(centre of the triangle)` holds, and unused vertices.
void cut(TriangleMesh& mesh, const std::function<bool(Vec3)>& gone);
/// Joins two meshes that share no vertex.
TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b);
/// The same, turned inside out.
TriangleMesh flipped(TriangleMesh mesh);
/// Every vertex moved.
TriangleMesh moved(TriangleMesh mesh, const std::function<Vec3(Vec3)>& to);

}  // namespace orbweave::test
