#include "engine/ball_pivoting/cell_grid.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "io/bounds.h"
#include "io/error.h"
#include "io/first_touch.h"
#include "partition/radix_sort.h"

namespace orbweave {
namespace {

using Range = tbb::blocked_range<std::size_t>;

/// Cells are wider than two radii by more than rounding, so that neighbours are never two apart.
constexpr double kCellMargin = 1.0 + 1e-9;

/// Cells along an axis, at most; numbers of three axes fit into a key.
constexpr std::int64_t kMostCells = 1 << 20;

/// Key of a point's cell: x fastest, rows and layers padded so that neighbours never wrap.
struct CellKeys {
  const CellSpace& space;
  std::int64_t low[3] = {};  // cell of the box's low corner
  std::uint64_t row = 0;
  std::uint64_t layer = 0;

  CellKeys(const Box& box, const CellSpace& cells) : space(cells) {
    std::uint64_t counts[3];
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = space.along(box.min[axis], axis);
      const std::int64_t count = space.along(box.max[axis], axis) - low[axis] + 1;
      if (count >= kMostCells)
        throw_usage("points to be worked on at once lie a million ball diameters apart");
      counts[axis] = static_cast<std::uint64_t>(count);
    }
    row = counts[0] + 2;
    layer = row * (counts[1] + 2);
  }
  std::uint64_t operator()(Vec3 p) const {
    const auto along = [&](int axis) {
      return static_cast<std::uint64_t>(space.along(p[axis], axis) - low[axis]) + 1;
    };
    return along(2) * layer + along(1) * row + along(0);
  }
};

}  // namespace

double largest_extent_in_cells(double ball_radius) {
  // Some cells for those that are begun at both ends, and for the perturbation.
  constexpr std::int64_t kSpare = 16;
  return static_cast<double>(kMostCells - kSpare) * 2.0 * ball_radius;
}

CellSpace::CellSpace(double ball_radius, double step, Vec3 origin) : steps_per_unit_(1.0 / step) {
  const double side = std::ceil(2.0 * ball_radius * kCellMargin * steps_per_unit_);
  side_ = static_cast<std::int64_t>(side);
  cells_per_step_ = 1.0 / side;
  for (int axis = 0; axis < 3; ++axis) {
    const double beyond = std::fmod(origin[axis] * steps_per_unit_, side);  // exact
    shift_[axis] = static_cast<std::int64_t>(beyond < 0.0 ? beyond + side : beyond);
  }
}

std::int64_t CellSpace::along(double local, int axis) const {
  const std::int64_t steps = static_cast<std::int64_t>(local * steps_per_unit_) + shift_[axis];
  // The quotient may be rounded across the border of a cell; the remainder is exact.
  auto cell = static_cast<std::int64_t>(static_cast<double>(steps) * cells_per_step_);
  std::int64_t rest = steps - cell * side_;
  for (; rest < 0; rest += side_) --cell;
  for (; rest >= side_; rest -= side_) ++cell;
  return cell;
}

CellGrid::CellGrid(std::span<const Vec3> local, std::span<const Vec3> normals,
                   const CellSpace& space) {
  const std::size_t n = local.size();
  reserve_touched(original_, n);
  for (auto* array : {&x_, &y_, &z_}) reserve_touched(*array, n + kLanePadding);
  reserve_touched(normals_, n);
  original_.resize(n);
  x_.assign(n + kLanePadding, 0.0);
  y_.assign(n + kLanePadding, 0.0);
  z_.assign(n + kLanePadding, 0.0);
  normals_.resize(n);
  begins_.assign(1, 0);
  if (n == 0) return;
  const CellKeys key_of(bounds_of(local), space);
  row_ = key_of.row;
  layer_ = key_of.layer;
  std::vector<KeyIndex> order;
  reserve_touched(order, n);
  order.resize(n);
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

CellGrid::CellGrid(const CellGrid& whole, std::span<const std::uint8_t> kept)
    : row_(whole.row_), layer_(whole.layer_) {
  const auto n = static_cast<std::size_t>(
      std::count_if(kept.begin(), kept.end(), [](auto k) { return k != 0; }));
  reserve_touched(original_, n);
  reserve_touched(normals_, n);
  for (auto* array : {&x_, &y_, &z_}) reserve_touched(*array, n + kLanePadding);
  for (std::uint32_t cell = 0; cell < whole.cells(); ++cell) {
    const std::size_t first = original_.size();
    for (std::uint32_t i = whole.begins_[cell]; i < whole.begins_[cell + 1]; ++i) {
      if (kept[i] == 0) continue;
      original_.push_back(i);
      x_.push_back(whole.x_[i]);
      y_.push_back(whole.y_[i]);
      z_.push_back(whole.z_[i]);
      normals_.push_back(whole.normals_[i]);
    }
    if (original_.size() == first) continue;
    keys_.push_back(whole.keys_[cell]);
    begins_.push_back(static_cast<std::uint32_t>(first));
  }
  begins_.push_back(static_cast<std::uint32_t>(n));
  for (auto* array : {&x_, &y_, &z_}) array->resize(n + kLanePadding, 0.0);
}

std::uint32_t CellGrid::cell_of(std::uint32_t i) const {
  const auto next = std::upper_bound(begins_.begin(), begins_.end(), i);
  return static_cast<std::uint32_t>(next - begins_.begin()) - 1;
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
