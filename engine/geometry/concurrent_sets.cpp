#include "engine/geometry/concurrent_sets.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

namespace orbweave {

std::vector<std::uint32_t> ConcurrentSets::take_roots() {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, parent_.size()), [&](const auto& range) {
    for (std::size_t x = range.begin(); x < range.end(); ++x) {
      const std::uint32_t root = find(static_cast<std::uint32_t>(x));
      std::atomic_ref(parent_[x]).store(root, std::memory_order_relaxed);
    }
  });
  return std::move(parent_);
}

}  // namespace orbweave
