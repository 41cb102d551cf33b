#include "engine/holes/triangulation/plane_triangulation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "engine/holes/patch/patch_mesh.h"
#include "tests/engine/plane_polygons.h"

using orbweave::CornerTriangle;
using orbweave::is_weakly_simple;
using orbweave::kPlaneExtent;
using orbweave::orientation;
using orbweave::PatchMesh;
using orbweave::PlanePoint;
using orbweave::side_of_circle;
using orbweave::triangulate_polygon;
using orbweave::Vec3;
using orbweave::test::Polygon;
using orbweave::test::Random;

namespace {

PatchMesh disc_of(const Polygon& points, std::uint32_t corners,
                  const std::vector<CornerTriangle>& triangles) {
  std::vector<Vec3> positions;
  for (const PlanePoint& p : points) {
    positions.push_back({static_cast<double>(p.x), static_cast<double>(p.y), 0.0});
  }
  std::vector<std::uint32_t> vertices;
  for (std::uint32_t i = 0; i < corners; ++i) {
    const auto first = std::find(points.begin(), points.begin() + corners, points[i]);
    vertices.push_back(static_cast<std::uint32_t>(first - points.begin()));
  }
  return PatchMesh(positions, vertices, triangles, {});
}

std::set<std::uint32_t> interior_used(std::uint32_t corners,
                                      const std::vector<CornerTriangle>& triangles) {
  std::set<std::uint32_t> used;
  for (const CornerTriangle& t : triangles) {
    for (const std::uint32_t v : t) {
      if (v >= corners) used.insert(v);
    }
  }
  return used;
}

/// No edge inside whose triangles' circles hold the point across.
bool is_delaunay(const Polygon& points, const std::vector<CornerTriangle>& triangles) {
  orbweave::HalfEdges mesh;
  REQUIRE(mesh.assign(triangles, static_cast<std::uint32_t>(points.size())));
  for (std::uint32_t h = 0; h < mesh.size(); ++h) {
    if (mesh.twin[h] == orbweave::kNone32) continue;
    if (side_of_circle(points[mesh.origin[h]], points[mesh.target(h)], points[mesh.apex(h)],
                       points[mesh.apex(mesh.twin[h])]) > 0) {
      return false;
    }
  }
  return true;
}

/// Everything that triangulate_polygon promises. Returns the interior points used.
std::set<std::uint32_t> require_sound(const Polygon& points, std::uint32_t corners,
                                      const std::vector<CornerTriangle>& triangles) {
  REQUIRE_FALSE(triangles.empty());
  std::int64_t area = 0;
  bool all_positive = true;
  for (const CornerTriangle& t : triangles) {
    const std::int64_t turn = orientation(points[t[0]], points[t[1]], points[t[2]]);
    all_positive = all_positive && turn > 0;
    area += turn;
  }
  CHECK(all_positive);
  CHECK(area == orbweave::test::doubled_area({points.begin(), points.begin() + corners}));
  CHECK(disc_of(points, corners, triangles).defect() == "");
  CHECK(is_delaunay(points, triangles));
  std::set<std::uint32_t> used = interior_used(corners, triangles);
  CHECK(triangles.size() == corners - 2 + 2 * used.size());
  return used;
}

Polygon with_random_points(Polygon polygon, std::size_t count, std::int64_t extent,
                           Random& random) {
  for (std::size_t i = 0; i < count; ++i) {
    const auto coordinate = [&] {
      return static_cast<std::int64_t>(random.below(2 * extent + 1)) - extent;
    };
    const std::int64_t x = coordinate();
    polygon.push_back({x, coordinate()});
  }
  return polygon;
}

/// Points strictly inside are all used, of equal ones one; others never.
void require_right_points_used(const Polygon& points, std::uint32_t corners,
                               const std::set<std::uint32_t>& used) {
  const Polygon polygon(points.begin(), points.begin() + corners);
  std::set<std::pair<std::int64_t, std::int64_t>> expected, found;
  for (std::uint32_t i = corners; i < points.size(); ++i) {
    if (orbweave::test::is_strictly_inside(polygon, points[i]))
      expected.insert({points[i].x, points[i].y});
    if (used.contains(i)) CHECK(found.insert({points[i].x, points[i].y}).second);
  }
  CHECK(found == expected);
}

}  // namespace

TEST_CASE("InCircleTestIsExactAtTheExtent") {
  // Four points of a circle of radius about 2^28, and one a single step inside or outside.
  constexpr std::int64_t kSide = kPlaneExtent;
  const PlanePoint a{-kSide, -kSide}, b{kSide, -kSide}, c{kSide, kSide};
  CHECK(side_of_circle(a, b, c, {-kSide, kSide}) == 0);
  CHECK(side_of_circle(a, b, c, {-kSide + 1, kSide}) == 1);
  CHECK(side_of_circle(a, b, c, {-kSide - 1, kSide}) == -1);
  const PlanePoint far_a{-2 * kSide, -2 * kSide}, far_b{2 * kSide, -2 * kSide},
      far_c{2 * kSide, 2 * kSide};
  CHECK(side_of_circle(far_a, far_b, far_c, {-2 * kSide, 2 * kSide}) == 0);
  CHECK(side_of_circle(far_a, far_b, far_c, {-2 * kSide + 1, 2 * kSide}) == 1);
  CHECK(orientation(far_a, far_b, far_c) == 16 * kSide * kSide);
}

TEST_CASE("StarPolygonsAreTriangulatedWithTheirPoints") {
  Random random(1);
  for (int round = 0; round < 150; ++round) {
    const auto corners = static_cast<std::uint32_t>(3 + random.below(40));
    const std::int64_t extent = round % 3 == 0 ? 12 : round % 3 == 1 ? 1000 : kPlaneExtent;
    const Polygon polygon = orbweave::test::star_polygon(corners, extent, random);
    if (!orbweave::test::is_weakly_simple_by_trial(polygon)) continue;
    const Polygon points = with_random_points(polygon, random.below(200), extent, random);
    const auto used = require_sound(points, corners, triangulate_polygon(points, corners));
    if (extent > 12) require_right_points_used(points, corners, used);
  }
}

TEST_CASE("ThinPolygonsAreTriangulatedWithTheirPoints") {
  Random random(2);
  for (const Polygon& polygon :
       {orbweave::test::spiral_polygon(1, 7), orbweave::test::spiral_polygon(6, 60),
        orbweave::test::comb_polygon(1), orbweave::test::comb_polygon(200)}) {
    const auto corners = static_cast<std::uint32_t>(polygon.size());
    CHECK(is_weakly_simple(polygon));
    require_sound(polygon, corners, triangulate_polygon(polygon, corners));
    const Polygon points = with_random_points(polygon, 3000, 1 << 20, random);
    require_right_points_used(points, corners,
                              require_sound(points, corners, triangulate_polygon(points, corners)));
  }
}

TEST_CASE("CollinearLatticesAreTriangulatedWithoutFlatTriangles") {
  constexpr std::int64_t kSide = 12;
  Polygon points = orbweave::test::lattice_square(kSide, 100);
  const auto corners = static_cast<std::uint32_t>(points.size());
  require_sound(points, corners, triangulate_polygon(points, corners));
  // Every lattice point, those on the rim too.
  for (std::int64_t y = 0; y <= kSide; ++y) {
    for (std::int64_t x = 0; x <= kSide; ++x) points.push_back({100 * x, 100 * y});
  }
  const auto used = require_sound(points, corners, triangulate_polygon(points, corners));
  CHECK(used.size() == (kSide - 1) * (kSide - 1));
}

TEST_CASE("RepeatedInteriorPointsAreUsedOnce") {
  Polygon points = {{0, 0}, {100, 0}, {100, 100}, {0, 100}};
  for (int i = 0; i < 5; ++i)
    points.insert(points.end(), {{50, 50}, {20, 30}, {100, 100}, {50, 0}});
  const auto used = require_sound(points, 4, triangulate_polygon(points, 4));
  CHECK(used.size() == 2);
}

TEST_CASE("TouchingPolygonsAreDiscsOfTheirCorners") {
  Random random(3);
  for (const auto& [name, polygon] : orbweave::test::touching_polygons()) {
    INFO(name);
    const auto corners = static_cast<std::uint32_t>(polygon.size());
    CHECK(orbweave::test::is_weakly_simple_by_trial(polygon));
    CHECK(is_weakly_simple(polygon));
    require_sound(polygon, corners, triangulate_polygon(polygon, corners));
    Polygon larger = polygon;
    for (PlanePoint& p : larger) p = {1000 * p.x, 1000 * p.y};
    const Polygon points = with_random_points(larger, 500, 20000, random);
    const auto triangles = triangulate_polygon(points, corners);
    CHECK_FALSE(require_sound(points, corners, triangles).empty());
  }
}

TEST_CASE("TouchingPolygonsAreTheSameFromAnyCornerOn") {
  for (const auto& [name, polygon] : orbweave::test::touching_polygons()) {
    Polygon turned = polygon;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      INFO(name << " from corner " << i);
      std::rotate(turned.begin(), turned.begin() + 1, turned.end());
      const auto corners = static_cast<std::uint32_t>(turned.size());
      require_sound(turned, corners, triangulate_polygon(turned, corners));
    }
  }
}

TEST_CASE("PolygonsThatAreNoDiscAreRefused") {
  for (const auto& [name, polygon] : orbweave::test::unsound_polygons()) {
    INFO(name);
    CHECK_FALSE(orbweave::test::is_weakly_simple_by_trial(polygon));
    CHECK_FALSE(is_weakly_simple(polygon));
    CHECK(triangulate_polygon(polygon, static_cast<std::uint32_t>(polygon.size())).empty());
  }
}

TEST_CASE("PointsOutOfTheExtentAreRefused") {
  const Polygon inside = {{-kPlaneExtent, -kPlaneExtent}, {kPlaneExtent, 0}, {0, kPlaneExtent}};
  CHECK(is_weakly_simple(inside));
  Polygon outside = inside;
  ++outside[1].x;
  CHECK_FALSE(is_weakly_simple(outside));
  CHECK(triangulate_polygon(outside, 3).empty());
}

TEST_CASE("RandomSmallPolygonsAreJudgedAsByTrial", "[costly]") {
  Random random(4);
  int sound = 0, touching = 0;
  for (int round = 0; round < 300000; ++round) {
    const auto corners = static_cast<std::uint32_t>(3 + random.below(7));
    const std::uint64_t side = 2 + random.below(4);
    Polygon polygon;
    std::set<std::pair<std::int64_t, std::int64_t>> distinct;
    for (std::uint32_t i = 0; i < corners; ++i) {
      const auto x = static_cast<std::int64_t>(random.below(side));
      polygon.push_back({x, static_cast<std::int64_t>(random.below(side))});
      distinct.insert({x, polygon.back().y});
    }
    const bool expected = orbweave::test::is_weakly_simple_by_trial(polygon);
    if (is_weakly_simple(polygon) != expected) {
      std::string text;
      for (const PlanePoint& p : polygon) {
        text += "{" + std::to_string(p.x) + ", " + std::to_string(p.y) + "} ";
      }
      FAIL(text << (expected ? "is" : "is not") << " weakly simple");
    }
    if (!expected) continue;
    ++sound;
    touching += distinct.size() < corners ? 1 : 0;
    if (distinct.size() == corners && round % 16 != 0) continue;
    require_sound(polygon, corners, triangulate_polygon(polygon, corners));
  }
  CHECK(sound > 1000);
  CHECK(touching > 50);
}

TEST_CASE("ForbiddenChordsAreFlippedAway") {
  // Of the convex polygon's chords one corner's are forbidden; it is cut off.
  Polygon polygon;
  for (int i = 0; i < 12; ++i) {
    polygon.push_back(
        {std::llround(1e6 * std::cos(i * 0.5236)), std::llround(1e6 * std::sin(i * 0.5236))});
  }
  for (std::uint32_t corner = 0; corner < 12; ++corner) {
    const auto forbidden = [corner](std::uint32_t a, std::uint32_t b) {
      return a == corner || b == corner;
    };
    const auto triangles = triangulate_polygon(polygon, 12, forbidden);
    REQUIRE(triangles.size() == 10);
    CHECK(disc_of(polygon, 12, triangles).defect() == "");
    const auto at_corner = std::count_if(triangles.begin(), triangles.end(), [&](const auto& t) {
      return std::find(t.begin(), t.end(), corner) != t.end();
    });
    CHECK(at_corner == 1);
  }
}

TEST_CASE("AllChordsForbiddenLeavesSomeTriangulation") {
  const Polygon polygon = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  CHECK(triangulate_polygon(polygon, 4, [](std::uint32_t, std::uint32_t) { return true; }).size() ==
        2);
}

TEST_CASE("TriangulationIsAPureFunctionOfItsPoints") {
  Random random(5);
  const Polygon polygon = orbweave::test::star_polygon(500, kPlaneExtent, random);
  const Polygon points = with_random_points(polygon, 5000, kPlaneExtent, random);
  CHECK(triangulate_polygon(points, 500) == triangulate_polygon(points, 500));
}

TEST_CASE("LargeHolesAreTriangulated") {
  Random random(6);
  const Polygon polygon = orbweave::test::star_polygon(10000, kPlaneExtent, random);
  const Polygon points = with_random_points(polygon, 100000, kPlaneExtent, random);
  require_sound(points, 10000, triangulate_polygon(points, 10000));
}
