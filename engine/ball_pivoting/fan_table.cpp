#include "engine/ball_pivoting/fan_table.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

namespace orbweave {
namespace {

constexpr std::uint32_t kBlockPoints = 4096;

/// Working arrays that grow to the largest neighbourhood met.
class ScratchSpace {
 public:
  void reserve(std::uint32_t candidates) {
    if (candidates <= capacity_) return;
    capacity_ = candidates + candidates / 2 + 64;
    const std::size_t room = capacity_ + kLanePadding;
    doubles_.assign(7 * room, 0.0);
    ids_.assign(room, 0);
    corners_.assign(corner_bound(capacity_), 0);
    double* at = doubles_.data();
    for (double** array : {&scratch_.dx, &scratch_.dy, &scratch_.dz, &scratch_.cap_height,
                           &scratch_.inverse_length, &scratch_.arc_begin, &scratch_.arc_length}) {
      *array = at;
      at += room;
    }
    scratch_.id = ids_.data();
  }
  const WalkScratch& arrays() const { return scratch_; }
  Corner* corners() { return corners_.data(); }

 private:
  std::uint32_t capacity_ = 0;
  std::vector<double> doubles_;
  std::vector<std::uint32_t> ids_;
  std::vector<Corner> corners_;
  WalkScratch scratch_;
};

/// First cells of blocks of about kBlockPoints points, and the end.
std::vector<std::uint32_t> cut_into_blocks(const CellGrid& grid) {
  std::vector<std::uint32_t> firsts;
  std::uint32_t next = 0;
  for (std::uint32_t cell = 0; cell < grid.cells(); ++cell) {
    if (grid.cell_begin(cell) < next) continue;
    firsts.push_back(cell);
    next = grid.cell_begin(cell) + kBlockPoints;
  }
  firsts.push_back(grid.cells());
  return firsts;
}

/// Activity by sorted index; empty when everybody is active.
std::vector<std::uint8_t> sorted_activity(const CellGrid& grid,
                                          std::span<const std::uint8_t> active) {
  std::vector<std::uint8_t> sorted;
  if (active.empty()) return sorted;
  sorted.resize(grid.size());
  for (std::uint32_t i = 0; i < grid.size(); ++i) sorted[i] = active[grid.original(i)];
  return sorted;
}

struct BlockFans {
  std::vector<Corner> corners;
  std::vector<std::uint32_t> begins;  // per walked point, in sorted order
};

}  // namespace

FanTable walk_all(const CellGrid& grid, double ball_radius, std::span<const std::uint8_t> active,
                  VectorWidth width) {
  FanTable table(grid.size());
  table.closed_.assign(grid.size(), 0);
  const std::vector<std::uint8_t> sorted_active = sorted_activity(grid, active);
  const std::uint8_t* activity = active.empty() ? nullptr : sorted_active.data();
  const WalkFunction walk = walk_function(width);
  const PointArrays arrays = grid.arrays();
  const std::vector<std::uint32_t> firsts = cut_into_blocks(grid);
  const std::size_t blocks = firsts.size() - 1;
  table.blocks_.resize(blocks);

  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    ScratchSpace space;
    CellGrid::Cursor cursor(grid, firsts[block]);
    std::vector<Corner> corners;
    const std::uint32_t begin = grid.cell_begin(firsts[block]);
    const std::uint32_t end = grid.cell_begin(firsts[block + 1]);
    corners.reserve(std::size_t{7} * (activity == nullptr ? end - begin : 0));
    std::vector<std::size_t> starts(end - begin + 1, 0);
    for (std::uint32_t cell = firsts[block]; cell < firsts[block + 1]; ++cell) {
      const std::uint32_t cell_begin = grid.cell_begin(cell), cell_end = grid.cell_end(cell);
      const bool wanted =
          activity == nullptr || std::any_of(activity + cell_begin, activity + cell_end,
                                             [](std::uint8_t a) { return a != 0; });
      CandidateRanges candidates;
      if (wanted) {
        candidates = cursor.around(cell);
        space.reserve(candidates.size());
      }
      for (std::uint32_t i = cell_begin; i < cell_end; ++i) {
        starts[i - begin] = corners.size();
        if (!wanted || (activity != nullptr && activity[i] == 0)) continue;
        Fan fan;
        fan.corners = space.corners();
        walk(arrays, candidates, i, ball_radius, activity, space.arrays(), fan);
        table.closed_[grid.original(i)] = fan.closed ? 1 : 0;
        for (std::uint32_t c = 0; c < fan.count; ++c) {
          corners.push_back(make_corner(grid.original(first_of(fan.corners[c])),
                                        grid.original(second_of(fan.corners[c]))));
        }
      }
    }
    starts[end - begin] = corners.size();
    corners.shrink_to_fit();
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint32_t point = grid.original(i);
      table.begin_[point] = corners.data() + starts[i - begin];
      table.count_[point] = static_cast<std::uint32_t>(starts[i - begin + 1] - starts[i - begin]);
    }
    table.blocks_[block] = std::move(corners);
  });
  return table;
}

}  // namespace orbweave
