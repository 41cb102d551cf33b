// The Delaunay triangulation against integers, which are exact: points with many ties.
#include "engine/voronoi/delaunay.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <vector>

using namespace orbweave;
using voronoi::kInfinite;
using voronoi::Tetrahedra;

namespace {

__extension__ using Wide = __int128;

using IntegerPoint = std::array<std::int64_t, 3>;
using IntegerPoints = std::vector<IntegerPoint>;
using Corners = std::array<std::uint32_t, 4>;

/// Points as doubles, moved and scaled by powers of two: every coordinate stays exact.
std::vector<Vec3> in_doubles(const IntegerPoints& points, double origin = 0.0, double scale = 1.0) {
  std::vector<Vec3> result;
  for (const IntegerPoint& p : points) {
    Vec3& to = result.emplace_back();
    for (int axis = 0; axis < 3; ++axis)
      to[axis] = scale * (origin + static_cast<double>(p[static_cast<std::size_t>(axis)]));
  }
  return result;
}

std::array<Wide, 3> offset(const IntegerPoint& from, const IntegerPoint& to) {
  return {Wide(to[0]) - from[0], Wide(to[1]) - from[1], Wide(to[2]) - from[2]};
}

Wide determinant(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b,
                 const std::array<Wide, 3>& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

Wide volume(const IntegerPoints& points, const Corners& c) {
  return determinant(offset(points[c[0]], points[c[1]]), offset(points[c[0]], points[c[2]]),
                     offset(points[c[0]], points[c[3]]));
}

/// Above 0 where p is inside the sphere of a positively oriented tetrahedron.
Wide inside_sphere(const IntegerPoints& points, const Corners& corners, const IntegerPoint& p) {
  std::array<std::array<Wide, 3>, 4> rows;
  std::array<Wide, 4> squares{};
  for (std::size_t i = 0; i < 4; ++i) {
    rows[i] = offset(p, points[corners[i]]);
    for (const Wide d : rows[i]) squares[i] += d * d;
  }
  return squares[0] * determinant(rows[1], rows[2], rows[3]) -
         squares[1] * determinant(rows[0], rows[2], rows[3]) +
         squares[2] * determinant(rows[0], rows[1], rows[3]) -
         squares[3] * determinant(rows[0], rows[1], rows[2]);
}

std::set<Corners> finite_cells(const Tetrahedra& tetrahedra) {
  std::set<Corners> cells;
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (!tetrahedra.is_finite(c)) continue;
    Corners corners = tetrahedra.vertices[c];
    std::sort(corners.begin(), corners.end());
    cells.insert(corners);
  }
  return cells;
}

/// Neighbours know each other and share the three vertices of a facet.
void require_links(const Tetrahedra& tetrahedra) {
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    for (int place = 0; place < 4; ++place) {
      const std::uint32_t next = tetrahedra.neighbors[c][static_cast<std::size_t>(place)];
      REQUIRE(next < tetrahedra.size());
      REQUIRE(
          tetrahedra.neighbors[next][static_cast<std::size_t>(tetrahedra.mirror_place(c, place))] ==
          c);
      for (int k = 0; k < 4; ++k) {
        const std::uint32_t vertex = tetrahedra.vertices[c][static_cast<std::size_t>(k)];
        const auto& others = tetrahedra.vertices[next];
        if (k != place) REQUIRE(std::find(others.begin(), others.end(), vertex) != others.end());
      }
    }
  }
}

/// No point lies inside the sphere of a tetrahedron, nor beyond a facet of the hull.
void require_empty_spheres(const IntegerPoints& points, const Tetrahedra& tetrahedra) {
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    const Corners& corners = tetrahedra.vertices[c];
    if (tetrahedra.is_finite(c)) {
      REQUIRE(volume(points, corners) > 0);
      for (const IntegerPoint& p : points) REQUIRE(inside_sphere(points, corners, p) <= 0);
      continue;
    }
    const auto at = static_cast<std::size_t>(tetrahedra.place_of_vertex(c, kInfinite));
    for (std::uint32_t p = 0; p < points.size(); ++p) {
      Corners seen = corners;
      seen[at] = p;
      REQUIRE(volume(points, seen) <= 0);
    }
  }
}

/// Every place has one vertex: the first point there.
void require_vertices(const IntegerPoints& points, const Tetrahedra& tetrahedra) {
  std::map<IntegerPoint, std::uint32_t> first;
  for (std::uint32_t p = 0; p < points.size(); ++p) first.emplace(points[p], p);
  std::set<std::uint32_t> expected, found;
  for (const auto& [place, p] : first) expected.insert(p);
  for (const Corners& corners : tetrahedra.vertices)
    for (const std::uint32_t vertex : corners)
      if (vertex != kInfinite) found.insert(vertex);
  CHECK(found == expected);
}

/// The tetrahedra as sets of places, whatever the indices are.
std::set<std::array<IntegerPoint, 4>> places(const IntegerPoints& points,
                                             const Tetrahedra& tetrahedra) {
  std::set<std::array<IntegerPoint, 4>> cells;
  for (const Corners& corners : finite_cells(tetrahedra)) {
    std::array<IntegerPoint, 4> at = {points[corners[0]], points[corners[1]], points[corners[2]],
                                      points[corners[3]]};
    std::sort(at.begin(), at.end());
    cells.insert(at);
  }
  return cells;
}

IntegerPoints random_points(std::size_t count, std::int64_t size, std::mt19937_64& bits) {
  IntegerPoints points(count);
  for (IntegerPoint& p : points)
    for (std::int64_t& x : p)
      x = static_cast<std::int64_t>(bits() % static_cast<std::uint64_t>(size));
  return points;
}

IntegerPoints grid(std::int64_t nx, std::int64_t ny, std::int64_t nz) {
  IntegerPoints points;
  for (std::int64_t x = 0; x < nx; ++x)
    for (std::int64_t y = 0; y < ny; ++y)
      for (std::int64_t z = 0; z < nz; ++z) points.push_back({x, y, z});
  return points;
}

/// Integer points on a sphere around the origin.
IntegerPoints sphere_points(std::int64_t squared_radius) {
  IntegerPoints points;
  const std::int64_t most =
      1 + static_cast<std::int64_t>(std::sqrt(static_cast<double>(squared_radius)));
  for (std::int64_t x = -most; x <= most; ++x)
    for (std::int64_t y = -most; y <= most; ++y)
      for (std::int64_t z = -most; z <= most; ++z)
        if (x * x + y * y + z * z == squared_radius) points.push_back({x, y, z});
  return points;
}

void require_delaunay(IntegerPoints points, std::mt19937_64& bits) {
  const Tetrahedra tetrahedra = voronoi::delaunay(in_doubles(points));
  require_links(tetrahedra);
  require_empty_spheres(points, tetrahedra);
  require_vertices(points, tetrahedra);
  const auto expected = places(points, tetrahedra);
  // Neither the order of the points, nor their place and scale decide a tie.
  std::shuffle(points.begin(), points.end(), bits);
  CHECK(places(points, voronoi::delaunay(in_doubles(points))) == expected);
  CHECK(places(points, voronoi::delaunay(in_doubles(points, 0x1p40, 0x1p-60))) == expected);
  CHECK(places(points, voronoi::delaunay(in_doubles(points, 0.0, 0x1p120))) == expected);
}

}  // namespace

TEST_CASE("DelaunaySpheresAreEmpty") {
  std::mt19937_64 bits(1);
  for (const std::int64_t size : {3, 4, 6, 10, 1000})
    for (const std::size_t count : {20U, 60U, 200U})
      require_delaunay(random_points(count, size, bits), bits);
}

TEST_CASE("DelaunayTakesGridsAndSpheres") {
  std::mt19937_64 bits(2);
  require_delaunay(grid(5, 5, 5), bits);
  require_delaunay(grid(2, 2, 40), bits);
  require_delaunay(grid(12, 12, 2), bits);
  require_delaunay(sphere_points(101), bits);
  require_delaunay(sphere_points(1025), bits);
}

TEST_CASE("DelaunayTakesPlanesWithOnePointBeside") {
  std::mt19937_64 bits(3);
  IntegerPoints points = grid(9, 9, 1);
  points.push_back({4, 4, 7});
  require_delaunay(points, bits);
  points = grid(1, 1, 30);
  points.push_back({1, 0, 3});
  points.push_back({0, 1, 3});
  require_delaunay(points, bits);
}

TEST_CASE("DelaunayVertexIsTheFirstOfSeveralInOnePlace") {
  std::mt19937_64 bits(4);
  IntegerPoints points = random_points(50, 5, bits);
  const IntegerPoints once = points;
  for (int i = 0; i < 3; ++i) points.insert(points.end(), once.begin(), once.end());
  std::shuffle(points.begin(), points.end(), bits);
  require_delaunay(points, bits);
}

TEST_CASE("DelaunayFillsTheHull") {
  // The volumes of the tetrahedra of a box of a grid add up to its own.
  const IntegerPoints points = grid(6, 5, 4);
  Wide sum = 0;
  for (const Corners& corners : voronoi::delaunay(in_doubles(points)).vertices)
    if (std::find(corners.begin(), corners.end(), kInfinite) == corners.end())
      sum += volume(points, corners);
  CHECK(sum == Wide(6 * 5 * 4 * 3));
}
