// Points sorted into cubic cells of two ball radii, so that everything within reach of a point
// lies in nine contiguous runs of the sorted arrays.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/walk.h"
#include "io/first_touch.h"

namespace orbweave {

/// Cells fixed in space by the ball radius: which cell a point lies in, relative to that of another
/// point, does not depend on the origin that their coordinates refer to. Exact.
class CellSpace {
 public:
  /// Cells of two radii and a little more, rounded up to whole steps of the lattice (see
  /// general_position.h). `origin` lies on the lattice.
  CellSpace(double ball_radius, double step, Vec3 origin);
  /// Number of the cell along one axis; `local` lies on the lattice, within 2^53 steps of zero.
  std::int64_t along(double local, int axis) const;

 private:
  double steps_per_unit_ = 1.0;
  double cells_per_step_ = 1.0;
  std::int64_t side_ = 1;                   // in steps
  std::array<std::int64_t, 3> shift_ = {};  // of the origin from the corner of its cell, in steps
};

/// Points whose box has at most this extent lie in few enough cells of a grid for that radius.
double largest_extent_in_cells(double ball_radius);

/// The sorted arrays and where each cell begins.
class CellGrid {
 public:
  /// `local`: positions relative to the origin of `space`. O(n); parallel on the calling arena.
  /// Throws Error (usage) beyond a million cells along an axis, see largest_extent_in_cells().
  CellGrid(std::span<const Vec3> local, std::span<const Vec3> normals, const CellSpace& space);

  /// The points of `whole` that are kept (one entry per sorted point), in the same cells and order;
  /// original() is the index in `whole`. O(n).
  CellGrid(const CellGrid& whole, std::span<const std::uint8_t> kept);

  std::uint32_t size() const { return static_cast<std::uint32_t>(original_.size()); }
  PointArrays arrays() const { return {x_.data(), y_.data(), z_.data(), normals_.data()}; }
  Vec3 position(std::uint32_t i) const { return {x_[i], y_[i], z_[i]}; }
  const Vec3& normal(std::uint32_t i) const { return normals_[i]; }
  /// Index in the input of sorted point i.
  std::uint32_t original(std::uint32_t i) const { return original_[i]; }

  std::uint32_t cells() const { return static_cast<std::uint32_t>(keys_.size()); }
  std::uint32_t cell_begin(std::uint32_t cell) const { return begins_[cell]; }
  std::uint32_t cell_end(std::uint32_t cell) const { return begins_[cell + 1]; }

  /// The cell of sorted point i. O(log cells).
  std::uint32_t cell_of(std::uint32_t i) const;

  /// Walks over cells in ascending order and keeps track of the runs around each.
  class Cursor {
   public:
    Cursor(const CellGrid& grid, std::uint32_t first_cell);
    /// Runs that hold every point within one cell side of the points of `cell`. Must be called
    /// with ascending cells.
    CandidateRanges around(std::uint32_t cell);

   private:
    const CellGrid& grid_;
    std::uint32_t low_[CandidateRanges::kMost];
  };

 private:
  void make_room(std::size_t points);

  UnsetVector<double> x_, y_, z_;  // padded by kLanePadding
  std::vector<Vec3> normals_;
  UnsetVector<std::uint32_t> original_;
  UnsetVector<std::uint64_t> keys_;  // of non-empty cells, ascending
  std::vector<std::uint32_t> begins_;
  std::uint64_t row_ = 0;    // key distance of neighbouring rows
  std::uint64_t layer_ = 0;  // key distance of neighbouring layers
};

}  // namespace orbweave
