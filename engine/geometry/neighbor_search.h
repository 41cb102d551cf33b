// Nearest neighbours of the points of a cloud that is already sorted along a space-filling curve.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/neighbor_kernel.h"
#include "engine/geometry/point_tree.h"
#include "io/vec3.h"

namespace orbweave {

/// Largest squared distance that counts as within `radius`: a hair below its square. The sum of a
/// coordinate and the radius is rounded where a chunk's halo is cut; what that may leave out,
/// points at the very radius, is no neighbour in the uncut cloud either.
inline double squared_reach(double radius) { return radius * radius * (1.0 - 1e-12); }

/// Positions in blocks of consecutive points with a hierarchy of their boxes. No sorting: points
/// in canonical order lie close to each other already; in any other order results are the same,
/// only slower. Results are exact: bounds of boxes are computed by the same operations as
/// distances, rounding is monotonous, so no point is missed, not even among equally distant ones.
/// How far a search looks is guessed and tried again where that was not far enough; results do not
/// depend on the guess.
/// Positions must be finite; fewer than 2^32. Safe for queries from many threads. O(n) to build.
///
/// Beside it there are PointTree, for positions in any order and queries that are none of them, and
/// NeighborGrid, for all within a fixed radius, in the order of the points.
class NeighborSearch {
 public:
  static constexpr std::uint32_t kBlock = kPointsPerBlock;  ///< queries of a block share work

  explicit NeighborSearch(std::span<const Vec3> positions);
  std::uint32_t size() const { return size_; }

  /// What a thread needs to search; reuse it: the last search tells how far the next has to look.
  class Query {
   public:
    /// Finds the `count` nearest others (the point itself is none) of points [begin, end) within
    /// a distance of `sqrt(max_squared)`. Points must lie in one block: begin / kBlock ==
    /// (end - 1) / kBlock. Nothing is found for point begin + i where `asked[i]` is 0; empty: all
    /// are asked for.
    void find(const NeighborSearch& search, std::uint32_t begin, std::uint32_t end,
              std::size_t count, double max_squared, std::span<const std::uint8_t> asked = {});
    /// Neighbours of point `index` of the last call, ascending. Of equally distant ones, those
    /// with the smaller index are nearer. Valid until the next call.
    std::span<const std::uint32_t> of(std::uint32_t index) const {
      return {found_index_.data() + row_begin(index), found_count_[index - begin_]};
    }
    /// Their squared distances.
    std::span<const double> squared_of(std::uint32_t index) const {
      return {found_squared_.data() + row_begin(index), found_count_[index - begin_]};
    }

   private:
    std::size_t row_begin(std::uint32_t index) const { return (index - begin_) * stride_; }
    void find_row(const NeighborSearch& search, std::uint32_t index, double max_squared);
    void collect(const NeighborSearch& search, double reach);
    void descend(const NeighborSearch& search, std::size_t level, std::uint32_t node, double reach);
    BlockColumns blocks() const;

    NeighborKernel kernel_ = neighbor_kernel(widest_supported());
    std::uint32_t begin_ = 0, end_ = 0;
    std::size_t stride_ = 0;
    std::vector<double> found_squared_;
    std::vector<std::uint32_t> found_index_;
    std::vector<std::size_t> found_count_;
    Vec3 low_, high_;      // box of the query points
    double reach_ = -1.0;  // squared; blocks within it of the box are collected
    std::vector<std::uint32_t> block_;
    std::vector<double> bounds_[6];
    std::vector<double> near_squared_;  // of one point
    std::vector<std::uint32_t> near_index_;
    double guess_ = 0.0;     // squared distance of the last neighbour, over their number
    double start_ = 0.0;     // where a row looks first
    double farthest_ = 0.0;  // the largest of all row_limit_
    /// The last row has all that were asked for within that squared distance; negative: it has not.
    double row_limit_ = -1.0;
    std::uint32_t row_before_ = 0;  // the last row's point
  };

 private:
  static constexpr std::uint32_t kFan = kBoxesAtOnce;  // children of a node
  struct Bounds {
    Vec3 low, high;
  };
  /// Boxes in columns: low x, y, z, high x, y, z. Those beyond the last are infinitely far away.
  struct Boxes {
    explicit Boxes(std::size_t count);
    void set(std::size_t box, const Bounds& bounds);
    Bounds at(std::size_t box) const;

    std::size_t size;
    std::vector<double> columns[6];
  };
  Bounds fill_block(std::span<const Vec3> positions, std::size_t block);
  PositionColumns columns() const;

  std::uint32_t size_ = 0;
  std::vector<double> x_, y_, z_;  // padded to whole blocks by what is no number
  std::vector<double> bounds_[6];  // of the parts of blocks: low x, y, z, high x, y, z
  std::vector<Boxes> levels_;      // of blocks, of their parents, ... of the root
};

}  // namespace orbweave
