// The cells that points are counted in, and how fine they can be for a given memory. Shared by the
// streaming count (count_grid.cpp) and the count in memory (cloud_counts.cpp), so that both end
// with the same cells.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/box.h"
#include "partition/radix_sort.h"
#include "partition/root_cube.h"

namespace orbweave {

// Cells along the root cube, log2: of the coarsest grid that nests in it (its origin is a
// multiple of side / 256), and of the finest, whose indices fit a Morton code with room for an
// anchor below the cube.
inline constexpr int kCoarsestLog2 = 8;
inline constexpr int kFinestLog2 = kMortonDepth - 1;

// The first points are kept as they are: most clouds' scale is known when these are counted, and
// small clouds get their grid in one go.
inline constexpr std::size_t kEarlyPoints = std::size_t{1} << 18;

// The streaming count is a tree: leaves of 4^3 cells, lower nodes of 4^3 leaves, upper nodes of 8^3
// lower nodes. Cells per node and axis, log2:
inline constexpr int kLeafLog2 = 2;
inline constexpr int kLowerLog2 = 4;
inline constexpr int kUpperLog2 = 7;

/// Bytes of a tree of counts. The sizes of its nodes are those of OpenVDB 10 on 64-bit machines,
/// written down: the cells of a cloud must not depend on a library's version.
constexpr std::size_t tree_bytes(std::size_t leaves, std::size_t lowers, std::size_t uppers) {
  return leaves * 296 + lowers * 544 + uppers * 4240;
}

/// Memory that the cells of a cloud of so many points may take, when the limit is `limit_bytes`.
std::size_t cells_limit_bytes(std::uint64_t points, std::size_t limit_bytes);

/// How often a grid's cells must double until the tree fits `limit_bytes`; at most `most`.
/// `leaves`: the Morton codes of its leaves, ascending (equal ones count once).
int doublings_to_fit(std::span<const KeyIndex> leaves, std::size_t limit_bytes, int most);

/// A cell by its indices.
struct CellIndex {
  int x = 0, y = 0, z = 0;
};

/// Cells anchored at the world's zero, their indices relative to the corner `anchor` below the
/// cloud: these are small even where the distance to zero in cells would overflow an integer.
struct CountLattice {
  double cell = 0.0;            ///< a power of two
  double cells_per_unit = 0.0;  ///< its reciprocal
  Vec3 anchor;                  ///< a multiple of the root cube's side and of the cell's
  Vec3 shift, low;

  CountLattice() = default;
  /// `root_side`: of the root cube of `bounds`. Indices of the cloud are 0 to 2 root_side / cell -
  /// 1, or 0 and 1 where cells are larger than that cube.
  CountLattice(double cell_side, const Box& bounds, double root_side);
  static Vec3 anchor_of(const Box& bounds, double side);

  int along(double value, int axis) const {
    const double cells = (value - shift[axis]) * cells_per_unit;
    const auto whole = static_cast<std::int64_t>(cells);
    const std::int64_t floor = whole - (cells < static_cast<double>(whole) ? 1 : 0);
    return static_cast<int>(floor - static_cast<std::int64_t>(low[axis]));
  }
  CellIndex at(Vec3 p) const { return {along(p.x, 0), along(p.y, 1), along(p.z, 2)}; }
  Vec3 corner(CellIndex at) const {
    return {anchor.x + at.x * cell, anchor.y + at.y * cell, anchor.z + at.z * cell};
  }
};

}  // namespace orbweave
