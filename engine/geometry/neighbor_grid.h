// Points sorted into cubic cells, for queries that all have the same radius.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/lattice_box.h"
#include "io/vec3.h"

namespace orbweave {

/// Cells are a hundredth wider than the radius, so that everything within the radius of a point
/// lies in the cells around its own in spite of rounding (as long as the radius is more than 1e-12
/// of the coordinates). A cell and the order within it do not depend on what other points there
/// are. Fewer than 2^32 points, finite. Building is O(n log n) on the calling TBB arena.
class NeighborGrid {
 public:
  NeighborGrid(std::span<const Vec3> positions, double radius);
  /// Of items that lie in these cells of some lattice.
  explicit NeighborGrid(std::span<const LatticeCell> of_items);

  static double cell_side(double radius) { return kSidePerRadius * radius; }
  static double radius_of_side(double side) { return side / kSidePerRadius; }

  std::uint32_t cells() const { return static_cast<std::uint32_t>(cells_.size()); }
  /// The occupied cells, ascending.
  std::span<const LatticeCell> lattice_cells() const { return cells_; }
  LatticeCell lattice_cell(std::uint32_t cell) const { return cells_[cell]; }
  /// Where a cell's points begin among those of all cells in a row.
  std::uint32_t begin(std::uint32_t cell) const { return begins_[cell]; }
  /// Points of a cell, ascending.
  std::span<const std::uint32_t> members(std::uint32_t cell) const;
  /// Points of the cells [first, last), cell by cell.
  std::span<const std::uint32_t> members(std::uint32_t first, std::uint32_t last) const;

 private:
  static constexpr double kSidePerRadius = 1.01;

  /// `box`: of the cells cell_at(0), cell_at(1) and so on.
  template <class CellAt>
  void sort(const LatticeBox& box, const CellAt& cell_at);
  template <class CellAt>
  void sort_by_number(const LatticeBox& box, const CellAt& cell_at);
  template <class CellAt>
  void sort_by_cell(const CellAt& cell_at);

  std::vector<std::uint32_t> order_;  ///< points by cell
  std::vector<LatticeCell> cells_;    ///< occupied ones, ascending
  std::vector<std::uint32_t> begins_;
};

}  // namespace orbweave
