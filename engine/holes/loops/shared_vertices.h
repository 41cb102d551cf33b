// Vertices that several loops share: where two loops meet at two vertices, a patch of each could
// join them, and the mesh would have that edge twice.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/problem/boundary_loop.h"

namespace orbweave {

/// The shared vertices of a list of loops. Memory grows with the number of shared vertices, not
/// with the number of their pairs.
class SharedVertices {
 public:
  SharedVertices() = default;
  explicit SharedVertices(std::span<const BoundaryLoop> loops);

  /// (vertex, group) of the vertices that loop `number`, which is `loop`, shares. Each other loop
  /// with two or more of these vertices is a group; groups of different loops have different
  /// numbers. No patch may join two vertices of a group: the patch of the other loop may join them.
  std::vector<std::array<std::uint64_t, 2>> groups_on(const BoundaryLoop& loop,
                                                      std::uint32_t number) const;
  /// Number of entries: one for each shared vertex and loop at that vertex.
  std::size_t size() const { return visits_.size(); }

 private:
  struct Visit {
    std::uint64_t vertex = 0;
    std::uint32_t loop = 0;
    friend auto operator<=>(const Visit&, const Visit&) = default;
  };
  std::vector<Visit> visits_;  // of vertices with several loops, sorted
};

}  // namespace orbweave
