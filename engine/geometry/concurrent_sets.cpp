#include "engine/geometry/concurrent_sets.h"

#include <algorithm>

#include "io/whole_loop.h"

namespace orbweave {

std::vector<std::uint32_t> ConcurrentSets::take_roots() {
  constexpr std::size_t kBlock = 8192;
  const std::size_t count = parent_.size();
  for_each_whole((count + kBlock - 1) / kBlock, [&](std::size_t block) {
    const std::size_t end = std::min(count, (block + 1) * kBlock);
    for (std::size_t x = block * kBlock; x < end; ++x) {
      const std::uint32_t root = find(static_cast<std::uint32_t>(x));
      std::atomic_ref(parent_[x]).store(root, std::memory_order_relaxed);
    }
  });
  return std::move(parent_);
}

}  // namespace orbweave
