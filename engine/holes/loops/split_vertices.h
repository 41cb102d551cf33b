// Vertices where several fans meet, taken apart so that the mesh is manifold.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// Groups of the triangles at one vertex that hang together over edges at that vertex, numbered in
/// the order of their first triangles: one number per triangle. O(n^2) for n triangles.
std::vector<std::uint32_t> fan_groups(std::span<const Triangle64> triangles, std::uint64_t vertex);

/// Vertices with several fans, ascending; without those at an edge of more than two triangles or of
/// two that run along it in the same direction.
/// `keep` is empty or says per triangle whether it counts.
std::vector<std::uint32_t> pinched_vertices(const TriangleMesh& mesh,
                                            std::span<const std::uint8_t> keep = {});

/// Doubles every vertex of the list with several fans: the first fan keeps it, each further one
/// gets a copy (position, normal, attributes), appended in order. Returns how many were added.
/// `vertices` ascending.
std::uint64_t split_vertices(TriangleMesh& mesh, std::span<const std::uint32_t> vertices);

}  // namespace orbweave
