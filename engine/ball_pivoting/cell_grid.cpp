#include "engine/ball_pivoting/cell_grid.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "io/bounds.h"
#include "io/error.h"
#include "io/first_touch.h"
#include "io/whole_loop.h"
#include "partition/radix_sort.h"

namespace orbweave {
namespace {

using Range = tbb::blocked_range<std::size_t>;

/// Points, or cells, that one thread takes at a time.
constexpr std::size_t kGrain = 4096;

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

/// Room for so many points, and the padding behind them.
void CellGrid::make_room(std::size_t points) {
  original_.resize(points);
  reserve_touched(normals_, points);
  normals_.resize(points);
  for (auto* array : {&x_, &y_, &z_}) {
    array->resize(points + kLanePadding);
    std::fill_n(array->end() - kLanePadding, kLanePadding, 0.0);
  }
}

CellGrid::CellGrid(std::span<const Vec3> local, std::span<const Vec3> normals,
                   const CellSpace& space) {
  const std::size_t n = local.size();
  make_room(n);
  begins_.assign(1, 0);
  if (n == 0) return;
  const CellKeys key_of(bounds_of(local), space);
  row_ = key_of.row;
  layer_ = key_of.layer;
  KeyList order(n);
  tbb::parallel_for(Range(0, n, kGrain), [&](const Range& r) {
    for (std::size_t i = r.begin(); i < r.end(); ++i) {
      order[i] = {key_of(local[i]), static_cast<std::uint32_t>(i)};
    }
  });
  radix_sort(order);
  tbb::parallel_for(Range(0, n, kGrain), [&](const Range& r) {
    for (std::size_t i = r.begin(); i < r.end(); ++i) {
      const std::uint32_t from = order[i].index;
      original_[i] = from;
      x_[i] = local[from].x;
      y_[i] = local[from].y;
      z_[i] = local[from].z;
      normals_[i] = normals[from];
    }
  });
  begins_ = run_begins(order);
  keys_.resize(begins_.size() - 1);
  tbb::parallel_for(Range(0, keys_.size(), kGrain), [&](const Range& r) {
    for (std::size_t cell = r.begin(); cell < r.end(); ++cell)
      keys_[cell] = order[begins_[cell]].key;
  });
  check_loops_are_whole();
}

CellGrid::CellGrid(const CellGrid& whole, std::span<const std::uint8_t> kept)
    : row_(whole.row_), layer_(whole.layer_) {
  // Blocks of cells, each with the number of cells and points kept before it.
  struct Before {
    std::size_t cells = 0;
    std::size_t points = 0;
  };
  const std::size_t blocks = (whole.cells() + kGrain - 1) / kGrain;
  const auto visit = [&](std::size_t block, const auto& use_cell, const auto& use_point) {
    const std::size_t end = std::min<std::size_t>(whole.cells(), (block + 1) * kGrain);
    for (std::size_t cell = block * kGrain; cell < end; ++cell) {
      bool any = false;
      for (std::uint32_t i = whole.begins_[cell]; i < whole.begins_[cell + 1]; ++i) {
        if (kept[i] == 0) continue;
        if (!any) use_cell(cell);
        any = true;
        use_point(i);
      }
    }
  };
  std::vector<Before> before(blocks + 1);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    visit(
        block, [&](std::size_t) { ++before[block + 1].cells; },
        [&](std::uint32_t) { ++before[block + 1].points; });
  });
  for (std::size_t block = 0; block < blocks; ++block) {
    before[block + 1].cells += before[block].cells;
    before[block + 1].points += before[block].points;
  }
  make_room(before.back().points);
  keys_.resize(before.back().cells);
  begins_.resize(before.back().cells + 1);
  begins_.back() = static_cast<std::uint32_t>(before.back().points);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    Before at = before[block];
    visit(
        block,
        [&](std::size_t cell) {
          keys_[at.cells] = whole.keys_[cell];
          begins_[at.cells++] = static_cast<std::uint32_t>(at.points);
        },
        [&](std::uint32_t i) {
          original_[at.points] = i;
          x_[at.points] = whole.x_[i];
          y_[at.points] = whole.y_[i];
          z_[at.points] = whole.z_[i];
          normals_[at.points++] = whole.normals_[i];
        });
  });
  check_loops_are_whole();
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
