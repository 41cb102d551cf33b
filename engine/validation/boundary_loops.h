// Boundary edges joined to loops.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace orbweave {

/// An edge of one triangle, and the fans (any labels) that it ends at its two vertices.
struct BoundaryEdge {
  std::uint32_t vertices[2] = {0, 0};
  std::uint32_t fans[2] = {0, 0};
};

/// Number of boundary loops. A fan that is not closed has two ends; two boundary edges that end
/// the same fan follow one another. A walk that comes to a vertex again closes a loop there, so
/// that every loop is simple: two holes that touch in a vertex are two loops, and so are two
/// sheets that touch in one. A walk that stops at a non-manifold edge counts as one loop.
/// O(n log n).
std::uint64_t count_boundary_loops(std::span<const BoundaryEdge> edges);

}  // namespace orbweave
