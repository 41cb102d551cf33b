// Which triangles a walk over a surface has met.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// Marks by the numbers that a surface gives its triangles. Triangles near one another have numbers
/// near one another: they lie together here, too. What the marks hold grows with the triangles met,
/// not with the surface.
class TriangleMarks {
 public:
  TriangleMarks() { slots_.resize(kLeastSlots); }

  /// Whether the triangle was not marked before.
  bool mark(std::uint64_t number) {
    const std::uint64_t key = number / kBlock + 1;
    std::size_t slot = slot_of(key);
    if (slots_[slot].key == 0) {
      if (2 * ++blocks_ > slots_.size()) {
        grow();
        slot = slot_of(key);
      }
      slots_[slot].key = key;
    }
    std::uint64_t& bits = slots_[slot].bits[number % kBlock / 64];
    const std::uint64_t bit = std::uint64_t{1} << (number % 64);
    const bool is_new = (bits & bit) == 0;
    bits |= bit;
    return is_new;
  }

  /// For surfaces that do not number their triangles.
  bool mark(const Triangle64& triangle) { return unnumbered_.insert(triangle).second; }

 private:
  static constexpr std::size_t kLeastSlots = 16;
  static constexpr std::size_t kBlock = 256;  ///< triangles
  struct Slot {
    std::uint64_t key = 0;  ///< 0: free
    std::array<std::uint64_t, kBlock / 64> bits{};
  };

  std::size_t slot_of(std::uint64_t key) const {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = static_cast<std::size_t>((key * kGolden) >> 32) & mask;
    while (slots_[slot].key != 0 && slots_[slot].key != key) slot = (slot + 1) & mask;
    return slot;
  }

  void grow() {
    std::vector<Slot> before(2 * slots_.size());
    before.swap(slots_);
    for (const Slot& slot : before)
      if (slot.key != 0) slots_[slot_of(slot.key)] = slot;
  }

  std::vector<Slot> slots_;
  std::size_t blocks_ = 0;
  std::set<Triangle64> unnumbered_;
};

}  // namespace orbweave
