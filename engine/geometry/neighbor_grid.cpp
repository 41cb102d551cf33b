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

/// The part of the lattice that is occupied: the number of a cell rises with the coordinate.
LatticeBox box_of(std::span<const Vec3> positions, double side) {
  if (positions.empty()) return {};
  Vec3 lowest = positions.front(), highest = lowest;
  for (const Vec3& p : positions) {
    lowest = {std::min(lowest.x, p.x), std::min(lowest.y, p.y), std::min(lowest.z, p.z)};
    highest = {std::max(highest.x, p.x), std::max(highest.y, p.y), std::max(highest.z, p.z)};
  }
  return {cell_of(lowest, side), cell_of(highest, side)};
}

}  // namespace

NeighborGrid::NeighborGrid(std::span<const Vec3> positions, double radius)
    : order_(positions.size()) {
  const double side = cell_side(radius);
  sort(box_of(positions, side), [&](std::uint32_t i) { return cell_of(positions[i], side); });
}

NeighborGrid::NeighborGrid(std::span<const LatticeCell> of_items) : order_(of_items.size()) {
  sort(LatticeBox::around(of_items), [&](std::uint32_t i) { return of_items[i]; });
}

template <class CellAt>
void NeighborGrid::sort(const LatticeBox& box, const CellAt& cell_at) {
  if (box.has_numbers())
    sort_by_number(box, cell_at);
  else
    sort_by_cell(cell_at);
}

template <class CellAt>
void NeighborGrid::sort_by_number(const LatticeBox& box, const CellAt& cell_at) {
  KeyList keys(order_.size());
  const auto items = [](std::size_t count) {
    return tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(count), 4096);
  };
  tbb::parallel_for(items(keys.size()), [&](const auto& range) {
    for (std::uint32_t i = range.begin(); i < range.end(); ++i)
      keys[i] = {box.number(cell_at(i)), i};
  });
  radix_sort(keys);
  tbb::parallel_for(items(keys.size()), [&](const auto& range) {
    for (std::uint32_t i = range.begin(); i < range.end(); ++i) order_[i] = keys[i].index;
  });
  begins_ = run_begins(keys);
  cells_.resize(begins_.size() - 1);
  tbb::parallel_for(items(cells_.size()), [&](const auto& range) {
    for (std::uint32_t cell = range.begin(); cell < range.end(); ++cell)
      cells_[cell] = cell_at(keys[begins_[cell]].index);
  });
}

template <class CellAt>
void NeighborGrid::sort_by_cell(const CellAt& cell_at) {
  std::iota(order_.begin(), order_.end(), 0u);
  tbb::parallel_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(cell_at(a), a) < std::pair(cell_at(b), b);
  });
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const LatticeCell cell = cell_at(order_[i]);
    if (i > 0 && cell == cells_.back()) continue;
    cells_.push_back(cell);
    begins_.push_back(static_cast<std::uint32_t>(i));
  }
  begins_.push_back(static_cast<std::uint32_t>(order_.size()));
}

std::span<const std::uint32_t> NeighborGrid::members(std::uint32_t cell) const {
  return members(cell, cell + 1);
}

std::span<const std::uint32_t> NeighborGrid::members(std::uint32_t first,
                                                     std::uint32_t last) const {
  return std::span(order_).subspan(begins_[first], begins_[last] - begins_[first]);
}

}  // namespace orbweave
