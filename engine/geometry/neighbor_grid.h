// Points sorted into cubic cells, for queries that all have the same radius.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "io/vec3.h"

namespace orbweave {

/// Number of a cell of the lattice that is anchored at the world's zero.
struct LatticeCell {
  std::int64_t z = 0;
  std::int64_t y = 0;
  std::int64_t x = 0;
  friend auto operator<=>(const LatticeCell&, const LatticeCell&) = default;
};

/// Cells are a hundredth wider than the radius, so that everything within the radius of a point
/// lies in the cells around its own in spite of rounding (as long as the radius is more than 1e-12
/// of the coordinates). A cell and the order within it do not depend on what other points there
/// are. Fewer than 2^32 points, finite. Building is O(n log n) on the calling TBB arena.
class NeighborGrid {
 public:
  NeighborGrid(std::span<const Vec3> positions, double radius);

  static double cell_side(double radius) { return kSidePerRadius * radius; }
  static double radius_of_side(double side) { return side / kSidePerRadius; }

  std::uint32_t cells() const { return static_cast<std::uint32_t>(cells_.size()); }
  LatticeCell lattice_cell(std::uint32_t cell) const { return cells_[cell]; }
  /// Where a cell's points begin among those of all cells in a row.
  std::uint32_t begin(std::uint32_t cell) const { return begins_[cell]; }
  /// Points of a cell, ascending.
  std::span<const std::uint32_t> members(std::uint32_t cell) const;
  /// Where the rows of cells around the last cell asked for were found: those around the next cell
  /// are not far behind. Any cursor gives the same cells.
  struct Cursor {
    std::array<std::uint32_t, 9> rows{};
  };
  /// Replaces `found` by the occupied cells among the 27 around (and with) a cell.
  void around(std::uint32_t cell, Cursor& cursor, std::vector<std::uint32_t>& found) const;
  /// Replaces `candidates` by the points of these cells, cell by cell in the order of the lattice:
  /// all that lie within the radius of any point of the cell, and more. `cells` is for its use.
  void gather(std::uint32_t cell, Cursor& cursor, std::vector<std::uint32_t>& cells,
              std::vector<std::uint32_t>& candidates) const;

 private:
  static constexpr double kSidePerRadius = 1.01;
  /// The part of the lattice that is occupied.
  struct CellBox {
    LatticeCell low, high;
    CellBox(std::span<const Vec3> positions, double side);
    /// Whether numbers of its cells, in their order, have 64 bits.
    bool has_numbers() const;
    std::uint64_t number(const LatticeCell& cell) const;
  };

  void sort_by_number(std::span<const Vec3> positions, double side);
  void sort_by_cell(std::span<const Vec3> positions, double side);

  CellBox box_;
  std::vector<std::uint32_t> order_;    ///< points by cell
  std::vector<LatticeCell> cells_;      ///< occupied ones, ascending
  std::vector<std::uint64_t> numbers_;  ///< of these; empty where they do not have 64 bits
  std::vector<std::uint32_t> begins_;
};

}  // namespace orbweave
