// Cells of a lattice, and numbers of those in a box.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <span>

namespace orbweave {

/// Number of a cell of the lattice that is anchored at the world's zero.
struct LatticeCell {
  std::int64_t z = 0;
  std::int64_t y = 0;
  std::int64_t x = 0;
  friend auto operator<=>(const LatticeCell&, const LatticeCell&) = default;
};

/// The cells between two corners, both included.
struct LatticeBox {
  LatticeCell low, high;

  /// The smallest one around all of some cells; a single cell around none.
  static LatticeBox around(std::span<const LatticeCell> cells) {
    LatticeBox box;
    if (!cells.empty()) box = {cells.front(), cells.front()};
    for (const LatticeCell& cell : cells) box.extend(cell);
    return box;
  }

  void extend(const LatticeCell& cell) {
    low = {std::min(low.z, cell.z), std::min(low.y, cell.y), std::min(low.x, cell.x)};
    high = {std::max(high.z, cell.z), std::max(high.y, cell.y), std::max(high.x, cell.x)};
  }

  /// Whether numbers of its cells, in their order, have 64 bits.
  bool has_numbers() const {
    constexpr double kMost = 0x1p62;
    return width(low.z, high.z) * width(low.y, high.y) * width(low.x, high.x) < kMost;
  }

  std::uint64_t number(const LatticeCell& cell) const {
    const std::int64_t row = (cell.z - low.z) * (high.y - low.y + 1) + (cell.y - low.y);
    return static_cast<std::uint64_t>(row * (high.x - low.x + 1) + (cell.x - low.x));
  }
  /// What a step adds to the number, between cells that both have one.
  std::uint64_t number_of_step(std::int64_t z, std::int64_t y, std::int64_t x) const {
    const std::int64_t rows = z * (high.y - low.y + 1) + y;
    return static_cast<std::uint64_t>(rows * (high.x - low.x + 1) + x);
  }

 private:
  static double width(std::int64_t from, std::int64_t to) {
    return static_cast<double>(to) - static_cast<double>(from) + 1.0;
  }
};

}  // namespace orbweave
