#include "engine/ball_pivoting/cell_grid.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "io/box.h"
#include "io/error.h"
#include "partition/radix_sort.h"

namespace orbweave {
namespace {

using Range = tbb::blocked_range<std::size_t>;

/// Key of a point's cell: x fastest, rows and layers padded so that neighbours never wrap.
struct CellKeys {
  Vec3 low;  // cell coordinates of the box's low corner
  std::uint64_t row = 0;
  std::uint64_t layer = 0;
  double cell_side = 1.0;

  CellKeys(const Box& box, double side) : cell_side(side) {
    std::uint64_t cells[3];
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::floor(box.min[axis] / side);
      const double count = std::floor(box.max[axis] / side) - low[axis] + 1.0;
      if (!(count < 0x1p20)) {
        throw_usage("the ball radius is too small for the cloud's size",
                    {.file = {},
                     .place = {},
                     .found = "more than a million ball diameters along an axis",
                     .expected = "a ball radius of about the point spacing",
                     .advice = "Use radii = \"auto\" or a larger radius"});
      }
      cells[axis] = static_cast<std::uint64_t>(count);
    }
    row = cells[0] + 2;
    layer = row * (cells[1] + 2);
  }
  std::uint64_t operator()(Vec3 p) const {
    const auto along = [&](int axis) {
      return static_cast<std::uint64_t>(std::floor(p[axis] / cell_side) - low[axis]) + 1;
    };
    return along(2) * layer + along(1) * row + along(0);
  }
};

Box bounds_of(std::span<const Vec3> points) {
  Box box;
  for (const Vec3& p : points) box.extend(p);
  return box;
}

}  // namespace

CellGrid::CellGrid(std::span<const Vec3> local, std::span<const Vec3> normals, double cell_side) {
  const std::size_t n = local.size();
  original_.resize(n);
  x_.assign(n + kLanePadding, 0.0);
  y_.assign(n + kLanePadding, 0.0);
  z_.assign(n + kLanePadding, 0.0);
  normals_.resize(n);
  begins_.assign(1, 0);
  if (n == 0) return;
  const CellKeys key_of(bounds_of(local), cell_side);
  row_ = key_of.row;
  layer_ = key_of.layer;
  std::vector<KeyIndex> order(n);
  tbb::parallel_for(Range(0, n, 4096), [&](const Range& r) {
    for (std::size_t i = r.begin(); i < r.end(); ++i) {
      order[i] = {key_of(local[i]), static_cast<std::uint32_t>(i)};
    }
  });
  radix_sort(order);
  tbb::parallel_for(Range(0, n, 4096), [&](const Range& r) {
    for (std::size_t i = r.begin(); i < r.end(); ++i) {
      const std::uint32_t from = order[i].index;
      original_[i] = from;
      x_[i] = local[from].x;
      y_[i] = local[from].y;
      z_[i] = local[from].z;
      normals_[i] = normals[from];
    }
  });
  begins_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    if (i != 0 && order[i].key == order[i - 1].key) continue;
    keys_.push_back(order[i].key);
    begins_.push_back(static_cast<std::uint32_t>(i));
  }
  begins_.push_back(static_cast<std::uint32_t>(n));
}

CellGrid::Cursor::Cursor(const CellGrid& grid, std::uint32_t first_cell) : grid_(grid) {
  std::fill(std::begin(low_), std::end(low_), 0);
  if (first_cell >= grid.cells()) return;
  // The run nine rows ahead begins at or after the one nine rows behind: one search serves all.
  const std::uint64_t reach = grid.layer_ + grid.row_ + 1;
  const std::uint64_t key = grid.keys_[first_cell];
  const auto at =
      std::lower_bound(grid.keys_.begin(), grid.keys_.end(), key > reach ? key - reach : 0);
  std::fill(std::begin(low_), std::end(low_), static_cast<std::uint32_t>(at - grid.keys_.begin()));
}

CandidateRanges CellGrid::Cursor::around(std::uint32_t cell) {
  CandidateRanges ranges;
  const std::uint64_t key = grid_.keys_[cell];
  const std::uint32_t cells = grid_.cells();
  for (int r = 0; r < CandidateRanges::kMost; ++r) {
    // Keys are padded by one cell all around, so key - layer - row - 1 never wraps below zero.
    const std::uint64_t middle = key + static_cast<std::uint64_t>(r / 3) * grid_.layer_ +
                                 static_cast<std::uint64_t>(r % 3) * grid_.row_ - grid_.layer_ -
                                 grid_.row_;
    std::uint32_t& low = low_[r];
    while (low < cells && grid_.keys_[low] + 1 < middle) ++low;
    std::uint32_t high = low;
    while (high < cells && grid_.keys_[high] <= middle + 1) ++high;
    if (high == low) continue;
    ranges.begin[ranges.count] = grid_.begins_[low];
    ranges.end[ranges.count] = grid_.begins_[high];
    ++ranges.count;
  }
  return ranges;
}

}  // namespace orbweave
