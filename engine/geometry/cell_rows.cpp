#include "engine/geometry/cell_rows.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace orbweave {
namespace {

constexpr std::uint32_t kAlong = 3;  // cells of a row

LatticeCell moved_by(const LatticeCell& cell, std::int64_t z, std::int64_t y, std::int64_t x) {
  return {cell.z + z, cell.y + y, cell.x + x};
}

}  // namespace

CellRows::CellRows(const NeighborGrid& grid) : grid_(grid), of_cell_(grid.cells()) {
  if (of_cell_.empty()) return;
  const std::span<const LatticeCell> cells = grid.lattice_cells();
  LatticeBox box = LatticeBox::around(cells);
  // Cells around those at the border have numbers of their own.
  box.extend(moved_by(box.low, -1, -1, -1));
  box.extend(moved_by(box.high, 1, 1, 1));
  if (box.has_numbers()) {
    std::vector<std::uint64_t> numbers;
    numbers.reserve(cells.size() + kAlong);
    for (const LatticeCell& cell : cells) numbers.push_back(box.number(cell));
    numbers.resize(cells.size() + kAlong, UINT64_MAX);
    find(numbers, [&](std::uint64_t number, std::int64_t z, std::int64_t y, std::int64_t x) {
      return number + box.number_of_step(z, y, x);
    });
  } else {
    constexpr std::int64_t kFar = INT64_MAX;
    std::vector<LatticeCell> keys(cells.begin(), cells.end());
    keys.resize(cells.size() + kAlong, {kFar, kFar, kFar});
    find(keys, moved_by);
  }
}

/// `keys`: of the cells, ascending, and one for each place of a row that come after all others.
/// Cells and one row of each are both ascending, so that one walk over the cells finds all.
template <class Key, class Moved>
void CellRows::find(const std::vector<Key>& keys, const Moved& moved) {
  constexpr std::uint32_t kGrain = 4096;
  using Range = tbb::blocked_range<std::uint32_t>;
  tbb::parallel_for(Range(0, grid_.cells(), kGrain), [&](const Range& range) {
    for (std::size_t row = 0; row < kRows; ++row) {
      const std::int64_t z = static_cast<std::int64_t>(row / 3) - 1;
      const std::int64_t y = static_cast<std::int64_t>(row % 3) - 1;
      const Key wanted = moved(keys[range.begin()], z, y, -1);
      auto at = static_cast<std::uint32_t>(std::lower_bound(keys.begin(), keys.end(), wanted) -
                                           keys.begin());
      for (std::uint32_t cell = range.begin(); cell < range.end(); ++cell) {
        const Key first = moved(keys[cell], z, y, -1), last = moved(keys[cell], z, y, 1);
        while (keys[at] < first) ++at;
        std::uint32_t count = 0;
        for (std::uint32_t i = 0; i < kAlong; ++i) count += keys[at + i] <= last ? 1 : 0;
        of_cell_[cell].begins[row] = at;
        of_cell_[cell].counts |= count << (2 * row);
      }
    }
  });
}

void CellRows::gather(std::uint32_t cell, std::vector<std::uint32_t>& candidates) const {
  candidates.clear();
  const Rows& rows = of_cell_[cell];
  for (std::size_t row = 0; row < kRows; ++row) {
    if (rows.count(row) == 0) continue;
    const auto points = grid_.members(rows.begins[row], rows.begins[row] + rows.count(row));
    candidates.insert(candidates.end(), points.begin(), points.end());
  }
}

}  // namespace orbweave
