#include "engine/voronoi/facets.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace orbweave::voronoi {
namespace {

std::size_t at(int place) { return static_cast<std::size_t>(place); }

}  // namespace

Triangle corners_of(const Tetrahedra& tetrahedra, FacetSide side) {
  const auto& vertices = tetrahedra.vertices[side.cell];
  const auto& facet = kFacet[at(side.place)];
  return {vertices[at(facet[0])], vertices[at(facet[2])], vertices[at(facet[1])]};
}

void sort_triangles(std::size_t points, std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> begin(points + 2, 0);
  for (const Triangle& t : triangles) ++begin[t[0] + 2];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Triangle> sorted(triangles.size());
  for (const Triangle& t : triangles) sorted[begin[t[0] + 1]++] = t;
  for (std::size_t p = 0; p < points; ++p)
    std::sort(sorted.begin() + begin[p], sorted.begin() + begin[p + 1]);
  triangles = std::move(sorted);
}

std::vector<Triangle> all_triangles(const Tetrahedra& tetrahedra, const FacetFlags& flags) {
  std::vector<Triangle> triangles;
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (!flags.has_any(c)) continue;
    for (int place = 0; place < 4; ++place) {
      const FacetSide side{c, place};
      if (!flags.has(side) || tetrahedra.neighbors[c][at(place)] < c) continue;
      Triangle corners = corners_of(tetrahedra, side);
      std::sort(corners.begin(), corners.end());
      triangles.push_back(corners);
    }
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace orbweave::voronoi
