// Lists as sorted sets.
#pragma once

#include <algorithm>
#include <vector>

namespace orbweave {

/// Sorts the list and keeps one of each value.
template <class T>
void sort_unique(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace orbweave
