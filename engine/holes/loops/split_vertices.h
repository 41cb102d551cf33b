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

/// Which triangles meet at some of the vertices.
class VertexStars {
 public:
  /// `vertices`: the ones to know, in any order. Takes one pass over the triangles.
  VertexStars(const TriangleMesh& mesh, std::span<const std::uint32_t> vertices);

  /// The vertices, ascending, each once.
  std::span<const std::uint32_t> vertices() const { return vertices_; }
  /// Numbers of the triangles at a known vertex, ascending.
  std::span<const std::uint32_t> at(std::uint32_t vertex) const;

 private:
  std::vector<std::uint32_t> vertices_;
  std::vector<std::size_t> first_;  // per known vertex, and one past the last
  std::vector<std::uint32_t> triangles_;
};

/// Whether several fans meet at a vertex of these triangles; false at an edge of more than two
/// triangles or of two that run along it in the same direction.
bool is_pinched(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles,
                std::uint32_t vertex);

/// Doubles every vertex of the list with several fans: the first fan keeps it, each further one
/// gets a copy (position, normal, attributes), appended in order. Returns how many were added.
/// `vertices` ascending, all known to `stars`, which are of this mesh.
std::uint64_t split_vertices(TriangleMesh& mesh, const VertexStars& stars,
                             std::span<const std::uint32_t> vertices);

}  // namespace orbweave
