#include "engine/geometry/neighbor_grid.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "partition/radix_sort.h"

namespace orbweave {
namespace {

/// Farther out, numbers of cells are no longer exact; they only have to stay numbers.
std::int64_t cell_number(double coordinate, double side) {
  constexpr double kLast = 0x1p61;
  return static_cast<std::int64_t>(std::clamp(std::floor(coordinate / side), -kLast, kLast));
}

LatticeCell cell_of(Vec3 p, double side) {
  return {cell_number(p.z, side), cell_number(p.y, side), cell_number(p.x, side)};
}

/// The first of ascending keys that does not come before `wanted`: searched for from `hint` in
/// steps that double.
template <class Key>
std::uint32_t first_from(std::span<const Key> keys, const Key& wanted, std::uint32_t hint) {
  std::uint32_t begin = hint, end = static_cast<std::uint32_t>(keys.size());
  if (hint > 0 && !(keys[hint - 1] < wanted)) {
    begin = 0;
    end = hint;
  }
  for (std::uint32_t step = 1; end - begin > step; step *= 2) {
    if (!(keys[begin + step - 1] < wanted)) {
      end = begin + step - 1;
      break;
    }
    begin += step;
  }
  return static_cast<std::uint32_t>(
      std::lower_bound(keys.begin() + begin, keys.begin() + end, wanted) - keys.begin());
}

}  // namespace

NeighborGrid::CellBox::CellBox(std::span<const Vec3> positions, double side) {
  if (positions.empty()) return;
  // The number of a cell rises with the coordinate.
  Vec3 lowest = positions.front(), highest = lowest;
  for (const Vec3& p : positions) {
    lowest = {std::min(lowest.x, p.x), std::min(lowest.y, p.y), std::min(lowest.z, p.z)};
    highest = {std::max(highest.x, p.x), std::max(highest.y, p.y), std::max(highest.z, p.z)};
  }
  low = cell_of(lowest, side);
  high = cell_of(highest, side);
}

bool NeighborGrid::CellBox::has_numbers() const {
  const auto width = [](std::int64_t from, std::int64_t to) {
    return static_cast<double>(to - from) + 1.0;
  };
  constexpr double kMost = 0x1p62;
  return width(low.z, high.z) * width(low.y, high.y) * width(low.x, high.x) < kMost;
}

std::uint64_t NeighborGrid::CellBox::number(const LatticeCell& c) const {
  const std::int64_t row = (c.z - low.z) * (high.y - low.y + 1) + (c.y - low.y);
  return static_cast<std::uint64_t>(row * (high.x - low.x + 1) + (c.x - low.x));
}

NeighborGrid::NeighborGrid(std::span<const Vec3> positions, double radius)
    : box_(positions, cell_side(radius)), order_(positions.size()) {
  if (box_.has_numbers())
    sort_by_number(positions, cell_side(radius));
  else
    sort_by_cell(positions, cell_side(radius));
}

void NeighborGrid::sort_by_number(std::span<const Vec3> positions, double side) {
  KeyList keys(positions.size());
  const auto items = [](std::size_t count) {
    return tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(count), 4096);
  };
  tbb::parallel_for(items(keys.size()), [&](const auto& range) {
    for (std::uint32_t i = range.begin(); i < range.end(); ++i)
      keys[i] = {box_.number(cell_of(positions[i], side)), i};
  });
  radix_sort(keys);
  tbb::parallel_for(items(keys.size()), [&](const auto& range) {
    for (std::uint32_t i = range.begin(); i < range.end(); ++i) order_[i] = keys[i].index;
  });
  begins_ = run_begins(keys);
  cells_.resize(begins_.size() - 1);
  numbers_.resize(cells_.size());
  tbb::parallel_for(items(cells_.size()), [&](const auto& range) {
    for (std::uint32_t cell = range.begin(); cell < range.end(); ++cell) {
      const KeyIndex& first = keys[begins_[cell]];
      cells_[cell] = cell_of(positions[first.index], side);
      numbers_[cell] = first.key;
    }
  });
}

void NeighborGrid::sort_by_cell(std::span<const Vec3> positions, double side) {
  std::iota(order_.begin(), order_.end(), 0u);
  tbb::parallel_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(cell_of(positions[a], side), a) < std::pair(cell_of(positions[b], side), b);
  });
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const LatticeCell cell = cell_of(positions[order_[i]], side);
    if (i > 0 && cell == cells_.back()) continue;
    cells_.push_back(cell);
    begins_.push_back(static_cast<std::uint32_t>(i));
  }
  begins_.push_back(static_cast<std::uint32_t>(order_.size()));
}

std::span<const std::uint32_t> NeighborGrid::members(std::uint32_t cell) const {
  return std::span(order_).subspan(begins_[cell], begins_[cell + 1] - begins_[cell]);
}

void NeighborGrid::around(std::uint32_t cell, Cursor& cursor,
                          std::vector<std::uint32_t>& found) const {
  found.clear();
  const LatticeCell middle = cells_[cell];
  std::size_t row = 0;
  for (std::int64_t z = middle.z - 1; z <= middle.z + 1; ++z) {
    for (std::int64_t y = middle.y - 1; y <= middle.y + 1; ++y) {
      std::uint32_t& hint = cursor.rows[row++];
      if (numbers_.empty()) {
        const LatticeCell last{z, y, middle.x + 1};
        hint = first_from<LatticeCell>(cells_, {z, y, middle.x - 1}, hint);
        for (std::uint32_t at = hint; at < cells() && cells_[at] <= last; ++at) found.push_back(at);
      } else if (z >= box_.low.z && z <= box_.high.z && y >= box_.low.y && y <= box_.high.y) {
        const std::uint64_t last = box_.number({z, y, std::min(middle.x + 1, box_.high.x)});
        const LatticeCell first{z, y, std::max(middle.x - 1, box_.low.x)};
        hint = first_from<std::uint64_t>(numbers_, box_.number(first), hint);
        for (std::uint32_t at = hint; at < cells() && numbers_[at] <= last; ++at)
          found.push_back(at);
      }
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
