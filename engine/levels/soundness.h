// Where a triangle mesh is no manifold.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// An edge by its vertices, the lower one first.
struct EdgeEnds {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  friend auto operator<=>(const EdgeEnds&, const EdgeEnds&) = default;
};

/// Vertices at which the triangles are no manifold, ascending: the ends of edges that more than two
/// triangles have or two run through in the same direction, and vertices with more than one fan.
/// About linear in the triangles.
std::vector<std::uint32_t> unsound_vertices(std::span<const Triangle> triangles);

/// Edges between two of some vertices (ascending), each once, ascending.
std::vector<EdgeEnds> edges_among(std::span<const Triangle> triangles,
                                  std::span<const std::uint32_t> vertices);

}  // namespace orbweave
