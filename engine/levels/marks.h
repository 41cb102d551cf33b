// Marks of some vertices.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// Whether a vertex is one of some, in constant time.
class Marks {
 public:
  explicit Marks(std::span<const std::uint32_t> ascending)
      : marks_(ascending.empty() ? 0 : std::size_t{ascending.back()} + 1) {
    for (const std::uint32_t vertex : ascending) marks_[vertex] = true;
  }
  bool operator[](std::uint32_t vertex) const { return vertex < marks_.size() && marks_[vertex]; }
  std::ptrdiff_t count(const Triangle& t) const {
    return std::ranges::count_if(t, [&](std::uint32_t vertex) { return (*this)[vertex]; });
  }

 private:
  std::vector<bool> marks_;
};

}  // namespace orbweave
