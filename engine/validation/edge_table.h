// The edges of a triangle mesh and the triangles at each of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// True when two of its vertices are the same.
inline bool is_degenerate(const Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// True when the triangle runs from `from` to `to` along its border.
inline bool runs_along(const Triangle& t, std::uint32_t from, std::uint32_t to) {
  return (t[0] == from && t[1] == to) || (t[1] == from && t[2] == to) ||
         (t[2] == from && t[0] == to);
}

/// All edges of a mesh, degenerate triangles left out. 8 bytes per vertex and 24 per triangle,
/// time O(triangles) for a bounded number of triangles per vertex; runs on the calling TBB arena.
class EdgeTable {
 public:
  /// One triangle's use of the edge (lower, upper).
  struct Use {
    std::uint32_t upper = 0;
    std::uint32_t triangle = 0;
  };

  /// Precondition: indices are in range, fewer than 2^32 triangles. Throws Error (interrupted).
  EdgeTable(std::span<const Triangle> triangles, std::size_t vertices,
            const StopToken* stop = nullptr);

  /// Calls visit(lower, upper, uses) for every edge in ascending order; uses by triangle.
  template <class Visit>
  void for_each_edge(Visit&& visit) const {
    for (std::size_t lower = 0; lower + 1 < first_use_.size(); ++lower) {
      std::uint64_t begin = first_use_[lower];
      while (begin < first_use_[lower + 1]) {
        std::uint64_t end = begin + 1;
        while (end < first_use_[lower + 1] && uses_[end].upper == uses_[begin].upper) ++end;
        visit(static_cast<std::uint32_t>(lower), uses_[begin].upper,
              std::span<const Use>(uses_.data() + begin, end - begin));
        begin = end;
      }
    }
  }

 private:
  std::vector<std::uint64_t> first_use_;  ///< per lower vertex, and one past the last
  std::vector<Use> uses_;
};

}  // namespace orbweave
