#include "engine/geometry/neighbor_grid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "partition/radix_sort.h"

namespace orbweave {
namespace {

/// Farther out, numbers of cells are no longer exact; they only have to stay numbers.
std::int64_t cell_number(double coordinate, double side) {
  constexpr double kLast = 0x1p61;
  return static_cast<std::int64_t>(std::clamp(std::floor(coordinate / side), -kLast, kLast));
}

std::vector<LatticeCell> cells_of(std::span<const Vec3> positions, double side) {
  std::vector<LatticeCell> cells(positions.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.size(), 4096), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const Vec3 p = positions[i];
      cells[i] = {cell_number(p.z, side), cell_number(p.y, side), cell_number(p.x, side)};
    }
  });
  return cells;
}

/// Numbers of the cells of a box of the lattice, in the order of the lattice.
class BoxNumbers {
 public:
  explicit BoxNumbers(std::span<const LatticeCell> cells) : low_(cells.front()), high_(low_) {
    for (const LatticeCell& c : cells) {
      low_ = {std::min(low_.z, c.z), std::min(low_.y, c.y), std::min(low_.x, c.x)};
      high_ = {std::max(high_.z, c.z), std::max(high_.y, c.y), std::max(high_.x, c.x)};
    }
  }
  /// Whether the numbers have 64 bits.
  bool fit() const {
    const auto width = [](std::int64_t low, std::int64_t high) {
      return static_cast<double>(high - low) + 1.0;
    };
    constexpr double kMost = 0x1p62;
    return width(low_.z, high_.z) * width(low_.y, high_.y) * width(low_.x, high_.x) < kMost;
  }
  std::uint64_t number(const LatticeCell& c) const {
    const std::int64_t row = (c.z - low_.z) * (high_.y - low_.y + 1) + (c.y - low_.y);
    return static_cast<std::uint64_t>(row * (high_.x - low_.x + 1) + (c.x - low_.x));
  }

 private:
  LatticeCell low_, high_;
};

/// Points by cell, those of a cell ascending.
std::vector<std::uint32_t> order_by_cell(std::span<const LatticeCell> cells) {
  std::vector<std::uint32_t> order(cells.size());
  if (cells.empty()) return order;
  if (const BoxNumbers box(cells); box.fit()) {
    std::vector<KeyIndex> keys(cells.size());
    for (std::uint32_t i = 0; i < keys.size(); ++i) keys[i] = {box.number(cells[i]), i};
    radix_sort(keys);
    for (std::size_t i = 0; i < keys.size(); ++i) order[i] = keys[i].index;
    return order;
  }
  std::iota(order.begin(), order.end(), 0u);
  tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tie(cells[a], a) < std::tie(cells[b], b);
  });
  return order;
}

}  // namespace

NeighborGrid::NeighborGrid(std::span<const Vec3> positions, double radius) {
  const std::vector<LatticeCell> cell_of = cells_of(positions, cell_side(radius));
  order_ = order_by_cell(cell_of);
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const LatticeCell& cell = cell_of[order_[i]];
    if (i > 0 && cell == cells_.back()) continue;
    cells_.push_back(cell);
    begins_.push_back(static_cast<std::uint32_t>(i));
  }
  begins_.push_back(static_cast<std::uint32_t>(order_.size()));
}

std::span<const std::uint32_t> NeighborGrid::members(std::uint32_t cell) const {
  return std::span(order_).subspan(begins_[cell], begins_[cell + 1] - begins_[cell]);
}

/// The first cell that does not come before `wanted`: searched for in steps that double.
std::uint32_t NeighborGrid::first_from(const LatticeCell& wanted, std::uint32_t hint) const {
  std::uint32_t begin = hint, end = cells();
  if (hint > 0 && !(cells_[hint - 1] < wanted)) {
    begin = 0;
    end = hint;
  }
  for (std::uint32_t step = 1; end - begin > step; step *= 2) {
    if (!(cells_[begin + step - 1] < wanted)) {
      end = begin + step - 1;
      break;
    }
    begin += step;
  }
  return static_cast<std::uint32_t>(
      std::lower_bound(cells_.begin() + begin, cells_.begin() + end, wanted) - cells_.begin());
}

void NeighborGrid::around(std::uint32_t cell, Cursor& cursor,
                          std::vector<std::uint32_t>& found) const {
  found.clear();
  const LatticeCell middle = cells_[cell];
  std::size_t row = 0;
  for (std::int64_t z = middle.z - 1; z <= middle.z + 1; ++z) {
    for (std::int64_t y = middle.y - 1; y <= middle.y + 1; ++y) {
      const LatticeCell last{z, y, middle.x + 1};
      std::uint32_t& hint = cursor.rows[row++];
      hint = first_from({z, y, middle.x - 1}, hint);
      for (std::uint32_t at = hint; at < cells() && cells_[at] <= last; ++at) found.push_back(at);
    }
  }
}

void NeighborGrid::gather(std::uint32_t cell, Cursor& cursor, std::vector<std::uint32_t>& cells,
                          std::vector<std::uint32_t>& candidates) const {
  around(cell, cursor, cells);
  candidates.clear();
  for (const std::uint32_t near : cells) {
    const auto points = members(near);
    candidates.insert(candidates.end(), points.begin(), points.end());
  }
}

}  // namespace orbweave
