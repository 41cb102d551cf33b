#include "engine/geometry/neighbor_grid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

namespace orbweave {
namespace {

struct CellPoint {
  LatticeCell cell;
  std::uint32_t point = 0;
  friend auto operator<=>(const CellPoint&, const CellPoint&) = default;
};

/// Farther out, numbers of cells are no longer exact; they only have to stay numbers.
std::int64_t cell_number(double coordinate, double side) {
  constexpr double kLast = 0x1p61;
  return static_cast<std::int64_t>(std::clamp(std::floor(coordinate / side), -kLast, kLast));
}

}  // namespace

NeighborGrid::NeighborGrid(std::span<const Vec3> positions, double radius) {
  const double side = cell_side(radius);
  std::vector<CellPoint> sorted(positions.size());
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, sorted.size(), 4096), [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          const Vec3 p = positions[i];
          sorted[i] = {{cell_number(p.z, side), cell_number(p.y, side), cell_number(p.x, side)},
                       static_cast<std::uint32_t>(i)};
        }
      });
  tbb::parallel_sort(sorted.begin(), sorted.end());
  const auto opens_cell = [&](std::size_t i) {
    return i == 0 || sorted[i].cell != sorted[i - 1].cell;
  };
  std::size_t cells = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) cells += opens_cell(i);
  cells_.reserve(cells);
  begins_.reserve(cells + 1);
  order_.resize(sorted.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    order_[i] = sorted[i].point;
    if (!opens_cell(i)) continue;
    cells_.push_back(sorted[i].cell);
    begins_.push_back(static_cast<std::uint32_t>(i));
  }
  begins_.push_back(static_cast<std::uint32_t>(sorted.size()));
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
