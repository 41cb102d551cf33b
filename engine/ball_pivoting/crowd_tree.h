// Points in groups of groups, for places where far more points are in reach of a ball than bound
// it.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/ball_pivoting/cell_grid.h"
#include "engine/ball_pivoting/walk.h"

namespace orbweave {

/// The points of a grid, halved along the longest axis of their box until eight are left, and the
/// spheres around all groups. O(n log n); parallel on the calling arena.
class CrowdTree {
 public:
  explicit CrowdTree(const CellGrid& grid);
  const GroupedPoints& groups() const { return groups_; }

 private:
  struct Level {
    std::vector<double> x, y, z, radius;
  };
  void put_in_order(const CellGrid& grid, std::uint32_t begin, std::uint32_t end);
  void add_level(const CellGrid& grid, std::uint64_t points_per_entry);

  std::vector<std::uint32_t> id_, place_;
  std::vector<Level> levels_;
  GroupedPoints groups_;
};

}  // namespace orbweave
