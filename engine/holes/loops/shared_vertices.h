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

/// Memory grows with the number of vertices that are shared, not with that of their pairs:
/// these are made for loops that are filled alone.
class SharedVertices {
 public:
  SharedVertices() = default;
  explicit SharedVertices(std::span<const BoundaryLoop> loops);

  /// Pairs of vertices of loop `number`, which is `loop`, that lie together on another loop, sorted
  /// and unique: no patch may join them, since another one may.
  std::vector<std::array<std::uint64_t, 2>> pairs_on(const BoundaryLoop& loop,
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
