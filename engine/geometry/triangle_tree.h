// How far points are from a mesh's surface.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/box.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Squared distance from p to the closed triangle abc, which may be degenerate.
double squared_distance_to_triangle(Vec3 p, Vec3 a, Vec3 b, Vec3 c);

/// A bounding volume hierarchy over the triangles of a mesh (over its vertices where it has no
/// triangles), a complete binary tree cut at medians. Finite positions and indices in range; the
/// mesh must outlive it. About 20 bytes per triangle beside the triangles' order; built in
/// O(n log n) on the calling TBB arena. Safe for queries from many threads.
class TriangleTree {
 public:
  explicit TriangleTree(const TriangleMesh& mesh);
  bool empty() const { return items_.empty(); }
  /// The triangle (vertex, of a mesh without triangles) nearest to a point. Of several equally near
  /// ones always the same.
  struct Nearest {
    double squared_distance;  ///< infinite when the tree is empty; exact to rounding
    std::uint32_t item;
  };
  Nearest nearest(Vec3 p) const { return nearest(p, -1.0); }
  /// Squared distance to the surface; infinite when the tree is empty. Exact to rounding.
  double squared_distance(Vec3 p) const { return nearest(p).squared_distance; }
  /// The same where it exceeds `enough`; else anything that does not.
  double squared_distance_beyond(Vec3 p, double enough) const {
    return nearest(p, enough).squared_distance;
  }

 private:
  /// Stops at the first that is no farther than `enough`, squared.
  Nearest nearest(Vec3 p, double enough) const;
  Triangle item(std::uint32_t index) const;
  Vec3 center(std::uint32_t index) const;
  void build(std::size_t node, std::size_t begin, std::size_t end, int depth);
  Nearest nearest_in(std::size_t begin, std::size_t end, Vec3 p, Nearest best) const;

  std::span<const Vec3> positions_;
  std::span<const Triangle> triangles_;
  std::vector<std::uint32_t> items_;  ///< triangles (or vertices), those of a leaf together
  std::vector<Box> boxes_;            ///< children of node i are 2i + 1 and 2i + 2
  int depth_ = 0;
};

}  // namespace orbweave
