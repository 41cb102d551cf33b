// Disjoint sets that several threads join at once. As in DisjointSets the smallest index of a set
// is its root, so the outcome depends on neither the order of the unions nor the threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace orbweave {

/// Union-find with path halving by atomic parents (Anderson and Woll, Wait-free Parallel Algorithms
/// for the Union-Find Problem, 1991). Parents only fall, so find() ends and no union is lost.
class ConcurrentSets {
 public:
  explicit ConcurrentSets(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  /// The root of a set: its smallest index once no thread unites any more.
  std::uint32_t find(std::uint32_t x) {
    for (;;) {
      std::uint32_t parent = load(x);
      if (parent == x) return x;
      const std::uint32_t above = load(parent);
      // A parent that another thread has lowered meanwhile stays as it is.
      if (above != parent) replace(x, parent, above);
      x = above;
    }
  }

  void unite(std::uint32_t a, std::uint32_t b) {
    for (;;) {
      a = find(a);
      b = find(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      if (replace(a, a, b)) return;  // false where `a` has got another root
    }
  }

  /// The root of each index; the sets are used up. Not while another thread unites. Parallel.
  std::vector<std::uint32_t> take_roots();

 private:
  std::uint32_t load(std::uint32_t x) {
    return std::atomic_ref(parent_[x]).load(std::memory_order_relaxed);
  }
  bool replace(std::uint32_t x, std::uint32_t expected, std::uint32_t wanted) {
    return std::atomic_ref(parent_[x])
        .compare_exchange_strong(expected, wanted, std::memory_order_relaxed);
  }

  std::vector<std::uint32_t> parent_;
};

}  // namespace orbweave
