// The counts of a cloud in memory: the cells that CountGrid ends with, from sorted Morton codes.
#pragma once

#include <span>
#include <vector>

#include "partition/count_lattice.h"
#include "partition/point_counts.h"

namespace orbweave {

/// Counts a whole cloud at once. The cells are those of a settled CountGrid of the usual memory
/// that was given the same points. O(n); holds 24 bytes per cell, and 32 per point while it is
/// made.
class CloudCounts final : public PointCounts {
 public:
  /// Finite points, fewer than 2^32, which must outlive the object. Runs on the calling TBB arena.
  explicit CloudCounts(std::span<const Vec3> positions);

  std::uint64_t points() const override { return positions_.size(); }
  const Box& bounds() const override { return bounds_; }
  double cell() const override { return lattice_.cell; }
  void for_each(const std::function<void(Vec3, std::uint64_t)>& visit) const override;
  std::size_t cells() const override;
  void for_each_at_once(
      const std::function<void(std::size_t, Vec3, std::uint64_t)>& visit) const override;
  /// Visits the points of a cloud of at most kEarlyPoints points, else the cells.
  void for_each_place(const std::function<void(Vec3, double, std::uint64_t)>& visit) const override;

 private:
  struct Cell {
    CellIndex at;
    std::uint32_t count = 0;
  };
  void count();

  std::span<const Vec3> positions_;
  Box bounds_;
  CountLattice lattice_;
  std::vector<Cell> cells_;
};

}  // namespace orbweave
