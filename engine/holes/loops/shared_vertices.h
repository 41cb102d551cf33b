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

/// Memory grows with the number of vertices that are shared, not with that of their pairs.
class SharedVertices {
 public:
  SharedVertices() = default;
  explicit SharedVertices(std::span<const BoundaryLoop> loops);

  /// (vertex, group) of the vertices that loop `number`, which is `loop`, has in common with
  /// another loop: a group for each other loop that has several, with a number that no group of any
  /// other loop has. No patch may join two vertices of a group, since another one may.
  std::vector<std::array<std::uint64_t, 2>> groups_on(const BoundaryLoop& loop,
                                                      std::uint32_t number) const;
  /// Entries that are held: one for each shared vertex and loop at it.
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
