// Nearest neighbours of the points of a cloud that is already sorted along a space-filling curve.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/block_scan.h"
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
/// Positions must be finite; fewer than 2^32. Safe for queries from many threads. O(n) to build.
///
/// Beside it there are PointTree, for positions in any order and queries that are none of them, and
/// NeighborGrid, for all within a fixed radius, in the order of the points.
class NeighborSearch {
 public:
  static constexpr std::uint32_t kBlock = kPointsPerBlock;  ///< queries of a block share work

  explicit NeighborSearch(std::span<const Vec3> positions);
  std::uint32_t size() const { return size_; }

  /// What a thread needs to search; reuse it.
  class Query {
   public:
    /// Finds the `count` nearest others (the point itself is none) of points [begin, end) within
    /// a distance of `sqrt(max_squared)`. Points must lie in one block: begin / kBlock ==
    /// (end - 1) / kBlock.
    void find(const NeighborSearch& search, std::uint32_t begin, std::uint32_t end,
              std::size_t count, double max_squared);
    /// Neighbours of point `index` of the last call, by (distance, index). Valid until the next.
    std::span<const Neighbor> of(std::uint32_t index) const {
      const std::size_t row = index - begin_;
      return {found_.data() + row * stride_, found_count_[row]};
    }

   private:
    friend class NeighborSearch;
    /// Upper bound of the distances that may still enter a row.
    double worst(std::size_t row) const {
      return found_[row * stride_ + stride_ - 1].squared_distance;
    }
    void enter(std::size_t row, Neighbor candidate);
    void bound_by_previous(const NeighborSearch& search, std::uint32_t i);
    void scan(const NeighborSearch& search, std::uint32_t block);
    void descend(const NeighborSearch& search, std::size_t level, std::uint32_t node);

    BlockScan scan_block_ = block_scan();
    std::uint32_t begin_ = 0, end_ = 0;
    bool bounded_ = false;  // the queries' own block is done
    std::size_t stride_ = 0;
    std::vector<Neighbor> found_;
    std::vector<std::size_t> found_count_;
    double farthest_ = 0.0;  // the largest of all worst()
    Vec3 low_, high_;        // box of the query points
  };

 private:
  static constexpr std::uint32_t kFan = 8;  // children of a node
  struct Bounds {
    Vec3 low, high;
  };
  std::uint32_t size_ = 0;
  std::vector<double> x_, y_, z_;            // padded to whole blocks
  std::vector<std::vector<Bounds>> levels_;  // of blocks, of their parents, ... of the root
};

}  // namespace orbweave
