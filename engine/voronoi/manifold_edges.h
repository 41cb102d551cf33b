// Meshes whose edges have at most two triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave::voronoi {

/// An edge, with one of its triangles.
struct MeshEdge {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  std::uint32_t triangle = 0;
};

/// The edges of more than two triangles, sorted. Takes O(triangles) and memory for all their sides.
std::vector<MeshEdge> crowded_edges(std::span<const Triangle> triangles);

/// Removes triangles until no edge has more than two and no directed edge more than one: at an edge
/// that has, the triangle of the largest circumball goes. Keeps the order of the others.
/// `suspects`: flags of the points that such edges may end at; other edges are not looked at.
void keep_manifold_edges(std::span<const Vec3> points, std::span<const std::uint8_t> suspects,
                         std::vector<Triangle>& triangles);

/// The squared radius of the circle through three points, as the square of a quotient: infinity for
/// points of one line.
double squared_circumradius(Vec3 a, Vec3 b, Vec3 c);

}  // namespace orbweave::voronoi
