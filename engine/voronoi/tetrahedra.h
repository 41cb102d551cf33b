// A triangulation of space into tetrahedra as plain arrays. The algorithms of the Voronoi family
// work on these alone; only delaunay.cpp, regular.cpp and exact_signs.cpp know CGAL.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "io/vec3.h"

namespace orbweave::voronoi {

/// The vertex at infinity, which every facet of the convex hull forms a tetrahedron with.
inline constexpr std::uint32_t kInfinite = 0xffffffffu;

/// No tetrahedron.
inline constexpr std::uint32_t kNone = 0xffffffffu;

/// The place of a value that is among four, without a branch.
inline int place_in(const std::array<std::uint32_t, 4>& values, std::uint32_t value) {
  return (values[1] == value ? 1 : 0) + (values[2] == value ? 2 : 0) + (values[3] == value ? 3 : 0);
}

struct Tetrahedra {
  /// Indices of the vertices, positively oriented: the fourth lies on the side of the first three
  /// that they are counter-clockwise seen from.
  std::vector<std::array<std::uint32_t, 4>> vertices;
  std::vector<std::array<std::uint32_t, 4>> neighbors;  ///< opposite the vertex of that place
  std::vector<std::uint8_t> finite;                     ///< no vertex is at infinity
  /// Centres of the circumballs (of weighted points: of the orthogonal balls); of a tetrahedron at
  /// infinity: the outward unit normal of its facet of the hull.
  std::vector<Vec3> centers;
  std::vector<double> radii;  ///< of the circumballs; without weights only

  std::size_t size() const { return vertices.size(); }
  bool is_finite(std::uint32_t cell) const { return finite[cell] != 0; }

  int place_of_vertex(std::uint32_t cell, std::uint32_t vertex) const {
    const auto& v = vertices[cell];
    return v[0] == vertex ? 0 : v[1] == vertex ? 1 : v[2] == vertex ? 2 : 3;
  }
  int place_of_neighbor(std::uint32_t cell, std::uint32_t neighbor) const {
    const auto& n = neighbors[cell];
    return n[0] == neighbor ? 0 : n[1] == neighbor ? 1 : n[2] == neighbor ? 2 : 3;
  }
  /// The place of the facet of `neighbors[cell][place]` that is this one of `cell`. Two tetrahedra
  /// may share more than one facet only where one is at infinity twice, which never happens.
  int mirror_place(std::uint32_t cell, int place) const {
    return place_of_neighbor(neighbors[cell][static_cast<std::size_t>(place)], cell);
  }
};

/// Places of a facet's vertices, counter-clockwise seen from outside the tetrahedron, where its
/// vertices are positively oriented and the facet is opposite place `i`.
inline constexpr std::array<std::array<int, 3>, 4> kFacet = {
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Of the two places other than i and j: the one with (i, j, it, other) positively oriented.
constexpr int find_next_place(int i, int j) {
  for (int k = 0; k < 4; ++k) {
    if (k == i || k == j) continue;
    const int l = 6 - i - j - k;
    const std::array<int, 4> order = {i, j, k, l};
    int inversions = 0;
    for (int a = 0; a < 4; ++a)
      for (int b = a + 1; b < 4; ++b)
        inversions += order[static_cast<std::size_t>(a)] > order[static_cast<std::size_t>(b)];
    if (inversions % 2 == 0) return k;
  }
  return -1;
}

/// Of find_next_place(); -1 where i is j.
inline constexpr auto kNextPlace = [] {
  std::array<std::array<std::int8_t, 4>, 4> table{};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      table[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
          static_cast<std::int8_t>(i == j ? -1 : find_next_place(i, j));
  return table;
}();

/// find_next_place() from a table: rings of tetrahedra are walked by it.
constexpr int next_place(int i, int j) {
  return kNextPlace[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
}

/// The tetrahedra at every vertex: those of vertex v are `cells[begin[v]]` to `cells[begin[v + 1]]`
/// (exclusive).
struct Stars {
  std::vector<std::uint32_t> begin;
  std::vector<std::uint32_t> cells;

  std::span<const std::uint32_t> of(std::uint32_t vertex) const {
    return std::span(cells).subspan(begin[vertex], begin[vertex + 1] - begin[vertex]);
  }
};

/// Numbers for the tetrahedra by their smallest vertices, given in the order of storage: where
/// neighbouring points have near indices, neighbouring tetrahedra lie near each other in memory.
/// Those with no vertex but the one at infinity have no number and stay as they are.
void number_by(std::vector<std::uint32_t>& smallest, std::size_t points);

Stars stars_of(const Tetrahedra& tetrahedra, std::size_t points);

}  // namespace orbweave::voronoi
