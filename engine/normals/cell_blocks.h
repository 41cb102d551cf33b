// Which parts of a lattice are empty, so that a ray passes over them at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

namespace orbweave {

/// A cell of a lattice, by its numbers along the axes.
using LatticePlace = std::array<std::int64_t, 3>;

struct LatticePlaceHash {
  std::size_t operator()(const LatticePlace& place) const noexcept;
};

/// Blocks of cells, each level's eight times as wide as those before, up to a level where one block
/// holds all cells that are not empty. A lattice that two clouds far from each other span has more
/// cells along a ray than could be looked at one by one.
class CellBlocks {
 public:
  /// `cells`: those that are not empty, with numbers from 0 to 2^61.
  explicit CellBlocks(std::span<const LatticePlace> cells);

  /// The widest block around a cell that is empty: the binary logarithm of its side in cells; 0
  /// where the smallest one, of 8 cells, is not empty. Cells may have numbers from -2^61 to 2^61.
  int empty_around(const LatticePlace& cell) const;

 private:
  bool is_empty(const LatticePlace& cell, int side_log) const;

  std::vector<std::unordered_set<LatticePlace, LatticePlaceHash>> levels_;  // whatever their order
};

}  // namespace orbweave
