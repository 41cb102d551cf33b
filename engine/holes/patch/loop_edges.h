// The edges of a loop.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace orbweave {

/// In the direction of the loop, sorted.
inline std::vector<std::array<std::uint32_t, 2>> edges_of_loop(
    const std::vector<std::uint32_t>& loop) {
  std::vector<std::array<std::uint32_t, 2>> edges;
  edges.reserve(loop.size());
  for (std::size_t i = 0; i < loop.size(); ++i)
    edges.push_back({loop[i], loop[(i + 1) % loop.size()]});
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace orbweave
