// The cells around each cell of a neighbour grid.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/neighbor_grid.h"

namespace orbweave {

/// Where the nine rows of three cells around every cell of a grid lie among the occupied cells. The
/// grid must outlive it. 40 bytes per cell; building is O(cells) on the calling TBB arena. Safe for
/// queries from many threads.
class CellRows {
 public:
  explicit CellRows(const NeighborGrid& grid);

  /// Calls visit(cell) for the occupied cells among the 27 around (and with) a cell, ascending.
  template <class Visit>
  void for_each_around(std::uint32_t cell, const Visit& visit) const {
    const Rows& rows = of_cell_[cell];
    for (std::size_t row = 0; row < kRows; ++row)
      for (std::uint32_t i = 0; i < rows.count(row); ++i) visit(rows.begins[row] + i);
  }
  /// Replaces `candidates` by the points of these cells, cell by cell in the order of the lattice:
  /// all that lie within the grid's radius of any point of the cell, and more.
  void gather(std::uint32_t cell, std::vector<std::uint32_t>& candidates) const;

 private:
  static constexpr std::size_t kRows = 9;
  /// Of a cell: the first cell of each row, and two bits for how many there are.
  struct Rows {
    std::array<std::uint32_t, kRows> begins{};
    std::uint32_t counts = 0;
    std::uint32_t count(std::size_t row) const { return counts >> (2 * row) & 3u; }
  };

  template <class Key, class Moved>
  void find(const std::vector<Key>& keys, const Moved& moved);

  const NeighborGrid& grid_;
  std::vector<Rows> of_cell_;
};

}  // namespace orbweave
