#include "engine/holes/crossing_patches.h"

namespace orbweave {

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
