// The nearest points of a site's points.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/neighbor_search.h"
#include "engine/geometry/point_tree.h"
#include "io/vec3.h"

namespace orbweave {

/// Finds what PointTree finds, for points of the cloud itself and many neighbours: the points are
/// put in an order in which neighbours lie beside each other, and searched block by block.
/// Positions must be distinct and finite; they need not outlive it. Fewer than 2^32 points. Safe
/// for queries from many threads.
class SiteSearch {
 public:
  explicit SiteSearch(std::span<const Vec3> positions);

  /// All points in the order of the search: near ones follow one another. Points that are asked for
  /// in this order are found sooner.
  std::span<const std::uint32_t> by_rank() const { return position_of_rank_; }
  /// Where a point comes in that order.
  std::uint32_t rank(std::uint32_t point) const { return rank_of_position_[point]; }

  /// What a thread needs to search; reuse it.
  class Query {
   public:
    /// Point `point` and its nearest others, `count` in all (fewer where there are no more),
    /// nearest first; equally near ones in order of index.
    void nearest(const SiteSearch& search, std::uint32_t point, std::size_t count,
                 std::vector<Neighbor>& found);

   private:
    static constexpr std::size_t kFew = 64;

    bool sort_by_counts(std::vector<Neighbor>& found);
    void sort(std::vector<Neighbor>& found);

    NeighborSearch::Query query_;
    std::vector<Neighbor> sorted_;
    std::vector<std::uint32_t> ends_;
  };

 private:
  std::vector<std::uint32_t> position_of_rank_;  ///< ranks are places in the order of the search
  std::vector<std::uint32_t> rank_of_position_;
  NeighborSearch search_;
};

}  // namespace orbweave
