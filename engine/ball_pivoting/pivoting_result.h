// What ball pivoting finds: triangles, and the fans around their vertices.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// A fan with a gap: the boundary runs previous -> vertex -> next along its triangles' edges.
struct BoundaryFan {
  std::uint32_t previous = 0;
  std::uint32_t vertex = 0;
  std::uint32_t next = 0;
  friend auto operator<=>(const BoundaryFan&, const BoundaryFan&) = default;
};

/// Which fan the triangle (vertex, first, ...) belongs to, at a vertex with several.
struct FanMember {
  std::uint32_t vertex = 0;
  std::uint32_t first = 0;
  std::uint32_t fan = 0;  ///< smallest first neighbour of the fan
  friend auto operator<=>(const FanMember&, const FanMember&) = default;
};

struct BallPivotingResult {
  /// Triangles whose smallest vertex is flagged as owned, each with its smallest vertex first,
  /// sorted. Indices into the input.
  std::vector<Triangle> triangles;
  /// Number of fans at each input point (0: no triangle uses it; above 1: not manifold there).
  /// This and the two lists are those of the uncut cloud at every vertex of `triangles`.
  std::vector<std::uint8_t> fans;
  std::vector<BoundaryFan> boundary;   ///< fans with a gap, vertices ascending
  std::vector<FanMember> fan_members;  ///< at vertices with several fans, sorted
  std::uint64_t conflicts_lost = 0;    ///< triangles that lost against a rival on an edge (owned)
  std::uint64_t isolated_dropped = 0;  ///< triangles that shared no edge with another (owned)
};

}  // namespace orbweave
