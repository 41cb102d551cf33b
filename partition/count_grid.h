// How many points lie where: a sparse OpenVDB grid of counts, filled while the cloud streams by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "io/box.h"

namespace orbweave {

/// Counts points in cubic cells of side 2^k, anchored at the world's zero. Neither bounds nor
/// scale need be known beforehand: the cell starts from the first points and doubles whenever
/// the grid would exceed its memory, or whenever indices would overflow. Counts are exact.
class CountGrid {
 public:
  /// `limit_bytes` bounds the grid's own memory.
  explicit CountGrid(std::size_t limit_bytes = std::size_t{48} << 20);
  ~CountGrid();
  CountGrid(CountGrid&&) noexcept;
  CountGrid& operator=(CountGrid&&) noexcept;

  /// Adds finite points.
  void add(std::span<const Vec3> positions);
  /// Makes cells coarser until their side is at most 1/256 of `root_side`... and not finer than
  /// the finest Morton cell; called once before the octree is cut.
  void settle(double root_side);

  std::uint64_t points() const;
  const Box& bounds() const;  ///< exact bounds of all points added
  double cell() const;        ///< side of a cell, a power of two
  std::size_t memory_bytes() const;
  /// Calls visit(min corner of the cell, count) for every non-empty cell.
  void for_each(const std::function<void(Vec3, std::uint64_t)>& visit) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
