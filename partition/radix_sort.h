// Sorting of 64-bit keys with an index attached: what canonical order, octree and cell grids need.
#pragma once

#include <cstdint>
#include <vector>

namespace orbweave {

/// A key and what it belongs to.
struct KeyIndex {
  std::uint64_t key = 0;
  std::uint32_t index = 0;
};

/// Sorts by key, ascending; equal keys keep their order. Parallel in the calling thread's TBB
/// arena. O(n); needs as much memory again for its time. Fewer than 2^32 items.
void radix_sort(std::vector<KeyIndex>& items);

}  // namespace orbweave
