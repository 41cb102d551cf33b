#include "engine/geometry/triangle_intersection.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "engine/holes/patch/patch_intersections.h"
#include "tests/support/clouds.h"

using namespace orbweave;
using orbweave::test::Random;

namespace {

/// Both orders, all rotations and both orientations must agree.
bool intersect(const std::vector<Vec3>& positions, Triangle s, Triangle t) {
  const bool first = triangles_intersect(positions, s, t);
  for (int flip = 0; flip < 4; ++flip) {
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        REQUIRE(triangles_intersect(positions, s, t) == first);
        REQUIRE(triangles_intersect(positions, t, s) == first);
        t = {t[1], t[2], t[0]};
      }
      s = {s[1], s[2], s[0]};
    }
    std::swap(flip % 2 == 0 ? s[0] : t[0], flip % 2 == 0 ? s[1] : t[1]);
  }
  return first;
}

/// The same under scaling and far from the origin.
bool intersect_anywhere(const std::vector<Vec3>& positions, Triangle s, Triangle t) {
  const bool result = intersect(positions, s, t);
  for (const double scale : {1e-6, 1e6}) {
    for (const Vec3 offset : {Vec3{}, scale * Vec3{4096.0, -65536.0, 1024.0}}) {
      std::vector<Vec3> moved;
      for (const Vec3 p : positions) moved.push_back(scale * p + offset);
      REQUIRE(intersect(moved, s, t) == result);
    }
  }
  return result;
}

}  // namespace

TEST_CASE("SharedEdgesAndVerticesAreNoIntersections") {
  const std::vector<Vec3> p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {-1, -1, 0}, {-1, 0, 0}};
  CHECK_FALSE(intersect(p, {0, 1, 2}, {2, 1, 3}));  // flat, over an edge
  CHECK_FALSE(intersect(p, {0, 1, 2}, {0, 5, 4}));  // flat, at a vertex
  CHECK_FALSE(intersect({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 1e-9}}, {0, 1, 2}, {1, 0, 3}));
}

TEST_CASE("NeighborsFoldedOntoEachOtherIntersect") {
  const std::vector<Vec3> p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 0.5, 0}};
  CHECK(intersect_anywhere(p, {0, 1, 2}, {1, 0, 3}));
}

TEST_CASE("TrianglesThatPierceEachOtherIntersect") {
  const std::vector<Vec3> p = {{0, 0, 0}, {2, 0, 0},  {0, 2, 0}, {0.5, 0.5, -1},    {0.5, 0.5, 1},
                               {3, 3, 0}, {5, 5, -1}, {5, 5, 1}, {-0.25, -0.25, 1}, {0.5, 0.5, 2}};
  CHECK(intersect_anywhere(p, {0, 1, 2}, {3, 4, 5}));
  CHECK_FALSE(intersect_anywhere(p, {0, 1, 2}, {5, 6, 7}));
  CHECK_FALSE(intersect_anywhere(p, {0, 1, 2}, {4, 8, 9}));
  SECTION("at a shared vertex") {
    CHECK(intersect_anywhere({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 1, -1}, {1, 1, 1}}, {0, 1, 2},
                             {0, 3, 4}));
    CHECK_FALSE(intersect_anywhere({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {-1, 1, -1}, {-1, 1, 1}},
                                   {0, 1, 2}, {0, 3, 4}));
  }
}

TEST_CASE("TrianglesInOnePlaneIntersectWhereTheyOverlap") {
  const std::vector<Vec3> p = {{0, 0, 0}, {2, 0, 0},  {0, 2, 0},  {0.5, 0.5, 0}, {3, 0.5, 0},
                               {3, 3, 0}, {2, 0, 0},  {4, 0, 0},  {4, 2, 0},     {5, 5, 0},
                               {6, 5, 0}, {-1, 1, 0}, {-1, 0, 0}, {1, 0.25, 0},  {0.25, 1, 0}};
  CHECK(intersect(p, {0, 1, 2}, {3, 4, 5}));
  CHECK(intersect(p, {0, 1, 2}, {6, 7, 8}));  // touch in a place that is two vertices
  CHECK_FALSE(intersect(p, {0, 1, 2}, {5, 9, 10}));
  CHECK_FALSE(intersect(p, {0, 1, 2}, {0, 11, 12}));
  CHECK(intersect(p, {0, 1, 2}, {0, 13, 14}));  // one inside the other's corner
}

TEST_CASE("ATriangleWithItsCornersOnALineIsASegment") {
  // Such triangles close the gap where a vertex lies on the edge of a larger triangle.
  const auto meets = [](std::vector<Vec3> others, Triangle t) {
    others.insert(others.begin(), {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}});
    return intersect(others, {0, 1, 2}, t);
  };
  SECTION("apart from others") {
    CHECK(meets({{1, -1, -1}, {1, 1, -1}, {1, 0, 1}}, {3, 4, 5}));
    CHECK(meets({{1, -1, 0}, {1, 1, 0}, {1, 0, 5}}, {3, 4, 5}));  // touched by an edge
    CHECK_FALSE(meets({{1, 1, -1}, {1, 3, -1}, {1, 2, 1}}, {3, 4, 5}));
    CHECK_FALSE(meets({{5, 0, 0}, {6, 1, 0}, {6, 0, 1}}, {3, 4, 5}));  // its line goes on to there
  }
  SECTION("apart from another segment") {
    CHECK(meets({{3, -1, 0}, {3, 1, 0}, {3, 2, 0}}, {3, 4, 5}));
    CHECK_FALSE(meets({{3, -1, 1}, {3, 1, 1}, {3, 2, 1}}, {3, 4, 5}));
    CHECK(meets({{3, 0, 0}, {5, 0, 0}, {6, 0, 0}}, {3, 4, 5}));
    CHECK_FALSE(meets({{5, 0, 0}, {6, 0, 0}, {7, 0, 0}}, {3, 4, 5}));
  }
  SECTION("at a vertex") {
    CHECK_FALSE(meets({{2, 1, 1}, {3, 1, 1}}, {1, 3, 4}));
    CHECK_FALSE(meets({{-1, 1, 0}, {-1, -1, 0}}, {0, 3, 4}));
    CHECK(meets({{1, 1, 0}, {1, -1, 0}}, {0, 3, 4}));  // runs inside of it
    CHECK(meets({{3, 1, 0}, {3, -1, 0}}, {1, 3, 4}));
    CHECK(meets({{3, 0, 0}, {3, 1, 0}}, {1, 3, 4}));  // runs along an edge
    CHECK_FALSE(meets({{5, 0, 0}, {6, 0, 0}}, {2, 3, 4}));
    CHECK_FALSE(meets({{2, 1, 0}, {2, 2, 0}}, {1, 3, 4}));
    CHECK(meets({{3, 0, 0}, {5, 0, 0}}, {1, 3, 4}));
  }
  SECTION("over an edge") {
    CHECK_FALSE(meets({{1, 1, 0}}, {1, 0, 3}));
    CHECK_FALSE(meets({{3, -1, 2}}, {2, 1, 3}));
    CHECK_FALSE(meets({{1, 3, 0}}, {0, 2, 3}));
    CHECK_FALSE(meets({{1, 0, 0}}, {0, 1, 3}));
    CHECK_FALSE(meets({{-1, 0, 0}}, {0, 1, 3}));
    CHECK(meets({{3, 0, 0}}, {0, 1, 3}));
  }
}

TEST_CASE("KnownSidesTellWhetherTrianglesAcrossEachOthersPlanesIntersect") {
  Random random(11);
  const auto place = [&] {
    return Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
  };
  const auto sides_of = [](const std::array<Vec3, 3>& plane, const std::array<Vec3, 3>& t) {
    std::array<int, 3> sides{};
    for (std::size_t k = 0; k < 3; ++k)
      sides[k] = side_of_plane(plane[0], plane[1], plane[2], t[k]);
    return sides;
  };
  const auto is_across = [](const std::array<int, 3>& sides) {
    return sides[0] * sides[1] * sides[2] != 0 && (sides[0] != sides[1] || sides[1] != sides[2]);
  };
  std::size_t met = 0, missed = 0;
  for (int i = 0; i < 4000; ++i) {
    const std::array<Vec3, 3> s = {place(), place(), place()}, t = {place(), place(), place()};
    const std::array<int, 3> of_s = sides_of(t, s), of_t = sides_of(s, t);
    if (!is_across(of_s) || !is_across(of_t)) continue;
    const bool expected = triangles_intersect(std::vector<Vec3>{s[0], s[1], s[2], t[0], t[1], t[2]},
                                              {0, 1, 2}, {3, 4, 5});
    CHECK(triangles_across_intersect(s, t, of_s, of_t) == expected);
    ++(expected ? met : missed);
  }
  CHECK(met > 100);
  CHECK(missed > 100);
}

TEST_CASE("TrianglesBesideAPlaneDoNotIntersect") {
  // On a coarse lattice many corners lie in others' planes and many triangles share corners.
  Random random(11);
  std::size_t beside = 0;
  for (int round = 0; round < 20'000; ++round) {
    std::vector<Vec3> p;
    for (int i = 0; i < 6; ++i)
      p.push_back({std::floor(5.0 * random.uniform()), std::floor(5.0 * random.uniform()),
                   std::floor(5.0 * random.uniform())});
    const Triangle s = {0, 1, 2};
    const auto shared = static_cast<std::uint32_t>(round % 3);
    const Triangle t = {3 - shared, 4 - shared, 5 - shared};
    if (!ApartByPlane(p, s).has_beside(p, t)) continue;
    ++beside;
    REQUIRE_FALSE(triangles_intersect(p, s, t));
  }
  CHECK(beside > 5'000);
}

TEST_CASE("SideOfPlaneIsExact") {
  // A plane that no double normal describes, and the nearest doubles on both sides of it.
  const Vec3 a{0.1, 0.1, 0.1}, b{12.7, 12.7, 12.7}, c{24.3, 24.3, 24.3 + 0x1p-40};
  for (const double x : {0.3, 5.0, 17.9}) {
    CHECK(side_of_plane(a, b, c, {x, x, x}) == 0);
    const Vec3 beside{std::nextafter(x, 100.0), x, x};
    const int side = side_of_plane(a, b, c, beside);
    CHECK(side != 0);
    CHECK(side_of_plane(b, a, c, beside) == -side);
    CHECK(side_of_plane(a, b, c, {std::nextafter(x, 0.0), x, x}) == -side);
  }
}

TEST_CASE("TreeFindsThePairsThatEveryPairTestFinds") {
  Random random(7);
  HoleProblem problem;
  HolePatch patch;
  const auto triangles = [&](std::size_t count, std::vector<Triangle>& out) {
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 at = 4.0 * Vec3{random.uniform(), random.uniform(), random.uniform()};
      const auto first = static_cast<std::uint32_t>(problem.positions.size());
      for (int k = 0; k < 3; ++k) problem.positions.push_back(at + 0.5 * random.direction());
      out.push_back({first, first + 1, first + 2});
    }
  };
  triangles(150, patch.triangles);
  triangles(150, problem.sheet);
  std::uint64_t expected = 0;
  for (std::size_t i = 0; i < patch.triangles.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      expected += triangles_intersect(problem.positions, patch.triangles[i], patch.triangles[k]);
    }
    for (const Triangle& t : problem.sheet) {
      expected += triangles_intersect(problem.positions, patch.triangles[i], t);
    }
  }
  REQUIRE(expected > 10);
  CHECK(count_intersections(problem, patch) == expected);
  CHECK(count_intersections(problem, patch, 3) == 3);
}
