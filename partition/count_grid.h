// How many points lie where: a sparse OpenVDB grid of counts, filled while the cloud streams by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "io/box.h"
#include "partition/point_counts.h"

namespace orbweave {

/// Counts points in cubic cells of side 2^k, anchored at the world's zero. Neither bounds nor
/// scale need be known beforehand: the first quarter of a million points are kept, then cells are
/// made as fine as memory allows, and double whenever the grid would exceed it. How fine they end
/// depends on the points alone and not on their order. Counts are exact.
class CountGrid final : public PointCounts {
 public:
  static constexpr std::size_t kUsualLimitBytes = std::size_t{16} << 20;

  /// `limit_bytes` bounds the grid's own memory, but for this: 256 cells along the side of the
  /// root cube are always kept (100 MiB when points fill space densely, rare in scans).
  /// `finest_cell`, a power of two: cells are no smaller.
  explicit CountGrid(std::size_t limit_bytes = kUsualLimitBytes, double finest_cell = 0.0);
  ~CountGrid() override;
  CountGrid(CountGrid&&) noexcept;
  CountGrid& operator=(CountGrid&&) noexcept;

  /// Adds finite points. Throws Error (resource) beyond 2^32 - 1 points in one cell.
  void add(std::span<const Vec3> positions);
  /// Makes cells no finer than the finest Morton cell of a root cube of side `root_side`, which
  /// must not be smaller than root_cube(bounds()); called once before the octree is cut. Cells
  /// are then at most root_side / 256 wide.
  void settle(double root_side);

  /// What a grid has counted, to be handed to another process.
  struct Part {
    double cell = 0.0;  ///< 0: `corners` are the points themselves
    Box bounds;
    std::vector<Vec3> corners;          ///< of the cells
    std::vector<std::uint64_t> counts;  ///< per cell, or per point
  };
  Part part() const;
  /// The grid of all parts' points: the same as if these had been added to one grid.
  static CountGrid of_parts(std::span<const Part> parts,
                            std::size_t limit_bytes = kUsualLimitBytes);

  std::uint64_t points() const override;
  const Box& bounds() const override;
  double cell() const override;
  std::size_t memory_bytes() const;  ///< held at the moment
  void for_each(const std::function<void(Vec3, std::uint64_t)>& visit) const override;
  std::size_t cells() const override;
  void for_each_at_once(
      const std::function<void(std::size_t, Vec3, std::uint64_t)>& visit) const override;
  /// Visits the points themselves as long as no cells were made of them, which for_each() and
  /// cell() do.
  void for_each_place(const std::function<void(Vec3, double, std::uint64_t)>& visit) const override;

 private:
  struct State;
  void add_points_of(const Part& part);
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
