// Vertices in groups. A vertex may be in several groups.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace orbweave {

/// Whether two vertices are in one group. `groups`: (vertex, group), sorted. O(log n + g) for n
/// entries and g groups of the two vertices.
inline bool share_a_group(std::span<const std::array<std::uint32_t, 2>> groups, std::uint32_t a,
                          std::uint32_t b) {
  const auto first_of = [&](std::uint32_t vertex) {
    return std::ranges::lower_bound(groups, std::array<std::uint32_t, 2>{vertex, 0});
  };
  auto at_a = first_of(a), at_b = first_of(b);
  while (at_a != groups.end() && at_b != groups.end() && (*at_a)[0] == a && (*at_b)[0] == b) {
    if ((*at_a)[1] == (*at_b)[1]) return true;
    if ((*at_a)[1] < (*at_b)[1])
      ++at_a;
    else
      ++at_b;
  }
  return false;
}

}  // namespace orbweave
