// How many points lie where, as counted by one of two ways: streaming (count_grid.h) or in memory
// (cloud_counts.h). Both count the same cloud in the same cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "io/box.h"

namespace orbweave {

/// Counts of points in cubic cells of side 2^k, anchored at the world's zero.
class PointCounts {
 public:
  virtual ~PointCounts() = default;
  virtual std::uint64_t points() const = 0;
  virtual const Box& bounds() const = 0;  ///< exact bounds of all points
  virtual double cell() const = 0;        ///< side of a cell, a power of two
  /// Calls visit(min corner of the cell, count) for every non-empty cell, in any order.
  virtual void for_each(const std::function<void(Vec3, std::uint64_t)>& visit) const = 0;
  /// Non-empty cells.
  virtual std::size_t cells() const = 0;
  /// As for_each(), on the threads of the calling thread's TBB arena, with the numbers of the
  /// cells: each from 0 to cells() - 1 once, and the same number for a cell every time.
  virtual void for_each_at_once(
      const std::function<void(std::size_t, Vec3, std::uint64_t)>& visit) const = 0;
  /// Calls visit(min corner, side, count) for what is known most exactly: the points themselves,
  /// with side 0, or the cells.
  virtual void for_each_place(
      const std::function<void(Vec3, double, std::uint64_t)>& visit) const = 0;

 protected:
  PointCounts() = default;
  PointCounts(const PointCounts&) = default;
  PointCounts& operator=(const PointCounts&) = default;
};

}  // namespace orbweave
