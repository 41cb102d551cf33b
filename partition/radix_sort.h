// Sorting of 64-bit keys with an index attached: what canonical order, octree and cell grids need.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/first_touch.h"

namespace orbweave {

/// A key and what it belongs to. Without initial values: room for millions of them that a sort is
/// about to fill would be written twice.
struct KeyIndex {
  std::uint64_t key;
  std::uint32_t index;
};

/// Keys that several threads make.
using KeyList = UnsetVector<KeyIndex>;

/// Sorts by key, ascending; equal keys keep their order. Parallel in the calling thread's TBB
/// arena. O(n); needs as much memory again for its time. Fewer than 2^32 items.
void radix_sort(std::span<KeyIndex> items);

/// Where the runs of equal keys begin, and the number of items. Parallel in the calling arena;
/// O(n).
std::vector<std::uint32_t> run_begins(std::span<const KeyIndex> items);

}  // namespace orbweave
