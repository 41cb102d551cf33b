#include "engine/holes/patch/rim_rings.h"

#include <algorithm>

namespace orbweave {

std::vector<std::uint32_t> rings_about(const HoleProblem& problem, std::uint32_t most) {
  std::vector<std::uint32_t> ring(problem.positions.size(), most + 1);
  for (const std::uint32_t v : problem.loop) ring[v] = 0;
  // A triangle takes part in at most two rounds; those far from the rim are looked at in each.
  std::vector<Triangle> left = problem.sheet;
  for (std::uint32_t round = 0; round < most && !left.empty(); ++round) {
    bool any = false;
    std::size_t kept = 0;
    for (const Triangle& t : left) {
      if (std::min({ring[t[0]], ring[t[1]], ring[t[2]]}) > round) {
        left[kept++] = t;
        continue;
      }
      for (const std::uint32_t v : t) {
        if (ring[v] <= most) continue;
        ring[v] = round + 1;
        any = true;
      }
    }
    left.resize(kept);
    if (!any) break;
  }
  return ring;
}

}  // namespace orbweave
