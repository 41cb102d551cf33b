// How a chunk numbers the vertices of its triangles: its own points from 0 in canonical order, then
// the vertices that other chunks own. 32 bits hold them, so a stored triangle takes 12 bytes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "io/triangle_mesh.h"

namespace orbweave {

class LocalNumbers {
 public:
  /// `first_vertex`: global number of the first own point. `outer`: global numbers of the others,
  /// ascending; must outlive the object.
  LocalNumbers(std::uint64_t first_vertex, std::uint64_t own, std::span<const std::uint64_t> outer)
      : first_(first_vertex), own_(own), outer_(outer) {}

  std::uint64_t own() const { return own_; }
  std::uint64_t count() const { return own_ + outer_.size(); }
  std::uint64_t global(std::uint32_t local) const {
    return local < own_ ? first_ + local : outer_[local - own_];
  }
  Triangle64 global(const Triangle& t) const { return {global(t[0]), global(t[1]), global(t[2])}; }
  /// count() where the chunk does not know the vertex.
  std::uint64_t local(std::uint64_t global) const {
    if (global >= first_ && global - first_ < own_) return global - first_;
    const auto at = std::lower_bound(outer_.begin(), outer_.end(), global);
    const bool found = at != outer_.end() && *at == global;
    return found ? own_ + static_cast<std::size_t>(at - outer_.begin()) : count();
  }

 private:
  std::uint64_t first_;
  std::uint64_t own_;
  std::span<const std::uint64_t> outer_;
};

}  // namespace orbweave
