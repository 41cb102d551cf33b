#include "engine/voronoi/undersampling.h"

#include <algorithm>
#include <tuple>

#include "engine/geometry/disjoint_sets.h"
#include "engine/voronoi/cocone.h"
#include "engine/voronoi/delaunay.h"
#include "engine/voronoi/poles.h"

namespace orbweave::voronoi {
namespace {

/// Joins the undersampled corners of each triangle.
void join_corners(const std::vector<Triangle>& triangles,
                  std::span<const std::uint8_t> well_sampled, DisjointSets& sets) {
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (well_sampled[a] == 0 && well_sampled[b] == 0) sets.unite(a, b);
    }
}

std::vector<UndersampledPlace> places_of(std::span<const Vec3> points,
                                         std::span<const std::uint8_t> well_sampled,
                                         DisjointSets& sets) {
  std::vector<UndersampledPlace> by_point(points.size());
  for (std::uint32_t p = 0; p < points.size(); ++p) {
    if (well_sampled[p] != 0) continue;
    UndersampledPlace& place = by_point[sets.find(p)];
    ++place.points;
    place.bounds.extend(points[p]);
  }
  std::erase_if(by_point, [](const UndersampledPlace& place) { return place.points == 0; });
  std::sort(by_point.begin(), by_point.end(),
            [](const UndersampledPlace& a, const UndersampledPlace& b) {
              const Vec3 p = a.bounds.min, q = b.bounds.min;
              return std::tie(b.points, p.x, p.y, p.z) < std::tie(a.points, q.x, q.y, q.z);
            });
  return by_point;
}

}  // namespace

Undersampling find_undersampling(std::span<const Vec3> points, const StopToken* stop) {
  Undersampling found;
  DisjointSets sets(points.size());
  {
    const Tetrahedra tetrahedra = delaunay(points, stop);
    const Poles poles = find_poles(points, tetrahedra, stop);
    const std::vector<CenterSides> sides =
        center_sides(points, tetrahedra, poles, kCoconeAngleRad, stop);
    const CoconeEdges edges = cocone_edges(tetrahedra, sides, stop);
    found.well_sampled = flat_points(points, tetrahedra, poles, sides, edges, {}, stop);
    join_corners(all_triangles(tetrahedra, cocone_facets(tetrahedra, edges, {}, stop)),
                 found.well_sampled, sets);
  }
  found.places = places_of(points, found.well_sampled, sets);
  for (const UndersampledPlace& place : found.places) found.points += place.points;
  return found;
}

}  // namespace orbweave::voronoi
