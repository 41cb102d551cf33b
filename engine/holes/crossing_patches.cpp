#include "engine/holes/crossing_patches.h"

#include <algorithm>

namespace orbweave {

std::vector<HolePair> holes_of_pairs(std::span<const TrianglePair> pairs,
                                     std::span<const std::int32_t> hole) {
  std::vector<HolePair> holes;
  holes.reserve(pairs.size());
  for (const TrianglePair& pair : pairs) {
    const auto [first, second] = std::minmax(hole[pair[0]], hole[pair[1]]);
    holes.push_back({first, second});
  }
  std::sort(holes.begin(), holes.end());
  return holes;
}

DroppedHoles patches_to_drop(std::span<const HolePair> pairs) {
  DroppedHoles dropped;
  for (const auto& [first, second] : pairs) {
    if (first == 0 && second != 0)
      dropped.emplace(second, "every patch crosses the surface");
    else if (first == second && first != 0)
      dropped.emplace(first, "every patch crosses itself");
  }
  for (const auto& [first, second] : pairs) {
    if (first == 0 || dropped.contains(first) || dropped.contains(second)) continue;
    dropped.emplace(second, "every patch crosses the patch of hole " + std::to_string(first));
  }
  return dropped;
}

}  // namespace orbweave
