// A part of the plane that polygons with holes cover.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "io/box.h"

namespace orbweave {

using AreaPoint = std::array<double, 2>;  ///< x, y

/// Closed rings: the last corner is joined to the first. A first corner that is repeated at the end
/// does no harm.
struct AreaPolygon {
  std::vector<AreaPoint> outer;
  std::vector<std::vector<AreaPoint>> holes;
};

/// The union of polygons. A point exactly on an edge, of a hole too, is inside; within a ring that
/// crosses itself the even-odd rule holds. Exact: a point is told from an edge by the sign of a
/// determinant, whatever its coordinates are, up to 1e75. Immutable: many threads may ask.
class PolygonArea {
 public:
  /// Precondition: at least one polygon, rings of at least three corners, finite coordinates up to
  /// 1e75.
  explicit PolygonArea(const std::vector<AreaPolygon>& polygons);

  /// O(edges in a strip of y).
  bool contains(double x, double y) const;
  /// No limits in z.
  const Box& bounds() const { return bounds_; }

 private:
  struct Edge {
    AreaPoint from;
    AreaPoint to;
    std::uint32_t polygon = 0;
    std::uint32_t ring = 0;  ///< of all polygons; the outer ring of a polygon is its first
    bool is_hole = false;
  };

  void add_ring(const std::vector<AreaPoint>& ring, std::uint32_t polygon, bool is_hole);
  void index_edges();
  std::size_t strip_of(double y) const;
  std::uint64_t entries_with(std::size_t strips) const;

  std::vector<Edge> edges_;  ///< those of a ring, and the rings of a polygon, side by side
  std::uint32_t rings_ = 0;
  Box bounds_;
  std::size_t strips_ = 1;
  std::vector<std::uint64_t> strip_begin_;  ///< in strip_edges_
  std::vector<std::uint32_t> strip_edges_;  ///< that touch the strip, ascending
};

}  // namespace orbweave
