// Polygons on the integer grid for tests of triangulations in the plane.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/holes/triangulation/plane_point.h"
#include "tests/support/clouds.h"

namespace orbweave::test {

using Polygon = std::vector<PlanePoint>;

struct NamedPolygon {
  std::string name;
  Polygon corners;
};

/// Corners in all directions from the middle, at random distances.
Polygon star_polygon(std::uint32_t corners, std::int64_t extent, Random& random);
/// A band that winds around the middle.
Polygon spiral_polygon(std::uint32_t turns, std::uint32_t per_turn);
/// Teeth along the x axis; their sides are collinear in rows.
Polygon comb_polygon(std::uint32_t teeth);
/// A square of `side` steps with a corner at every step.
Polygon lattice_square(std::int64_t side, std::int64_t step);
/// Weakly simple polygons, none of them simple: bridges, slits, coincident corners.
std::vector<NamedPolygon> touching_polygons();
/// Closed polygons that are not weakly simple, or whose inside is no disc.
std::vector<NamedPolygon> unsound_polygons();

/// Twice the signed area.
std::int64_t doubled_area(const Polygon& polygon);
/// True when p is strictly inside a simple polygon.
bool is_strictly_inside(const Polygon& polygon, PlanePoint p);
/// By all pairs of edges and corners and by all triangulations: no two edges cross, no corner lies
/// on another edge, no edge is repeated in its direction, the angles inside sum to (n - 2) pi and
/// those at one point do not overlap, and some triangulation has positive triangles only.
bool is_weakly_simple_by_trial(const Polygon& polygon);

}  // namespace orbweave::test
