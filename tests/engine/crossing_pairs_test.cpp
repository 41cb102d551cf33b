#include "engine/geometry/crossing_pairs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "engine/geometry/triangle_intersection.h"
#include "engine/holes/crossing_patches.h"
#include "engine/holes/fill_mesh.h"
#include "engine/holes/patch/numbers_near.h"
#include "engine/validation/mesh_crossings.h"
#include "tests/support/clouds.h"
#include "tests/support/meshes.h"

using namespace orbweave;
using namespace orbweave::test;

namespace {

struct Soup {
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
};

/// Triangles of all sizes, far from the origin; some share vertices.
Soup random_soup(std::size_t count, Random& random) {
  Soup soup;
  for (std::size_t t = 0; t < count; ++t) {
    const Vec3 center = Vec3{5e5, 4e6, 100.0} + 10.0 * random.direction();
    const double size = 0.05 * std::pow(40.0, random.uniform());
    Triangle triangle;
    for (std::uint32_t& v : triangle) {
      v = static_cast<std::uint32_t>(soup.positions.size());
      soup.positions.push_back(center + size * random.direction());
    }
    if (t > 0 && t % 3 == 0) triangle[1] = soup.triangles.back()[random.below(3)];
    soup.triangles.push_back(triangle);
  }
  return soup;
}

std::vector<TrianglePair> by_trying_all(const Soup& soup, const PairsWanted& wanted) {
  std::vector<TrianglePair> pairs;
  for (std::uint32_t i = 0; i < soup.triangles.size() && i < wanted.first_below; ++i) {
    for (std::uint32_t j = i + 1; j < soup.triangles.size(); ++j) {
      const bool passed_over = !wanted.mark.empty() && wanted.mark[i] == 0 && wanted.mark[j] == 0;
      if (!passed_over && triangles_intersect(soup.positions, soup.triangles[i], soup.triangles[j]))
        pairs.push_back({i, j});
    }
  }
  return pairs;
}

/// The holes that are no outer borders.
std::vector<HoleFacts> caps_of(const FilledMesh& filled) {
  std::vector<HoleFacts> caps;
  for (const HoleFacts& hole : filled.holes)
    if (hole.open != OpenReason::kOuterBorder) caps.push_back(hole);
  return caps;
}

}  // namespace

TEST_CASE("TrianglesNearPlacesAreThoseWhoseBoxesMeetThem") {
  Random random(31);
  const Soup soup = random_soup(3000, random);
  std::vector<Box> places;
  for (int i = 0; i < 40; ++i) {
    const Vec3 center = Vec3{5e5, 4e6, 100.0} + 10.0 * random.direction();
    places.push_back(Box{center, center}.grown(random.uniform()));
  }
  const auto box = [&](std::uint32_t t) { return box_of(soup.positions, soup.triangles[t]); };
  std::vector<std::uint32_t> expected;
  for (std::uint32_t t = 0; t < soup.triangles.size(); ++t)
    if (std::any_of(places.begin(), places.end(),
                    [&](const Box& place) { return place.intersects(box(t)); }))
      expected.push_back(t);
  REQUIRE(expected.size() > 10);
  REQUIRE(expected.size() < 2990);
  CHECK(numbers_near(3000, BoxTree(places), box) == expected);
  CHECK(numbers_near(0, BoxTree(places), box).empty());
  CHECK(numbers_near(3000, BoxTree(std::vector<Box>{}), box).empty());
}

TEST_CASE("CrossingPairsAreThoseThatTryingAllFinds") {
  Random random(7);
  for (const std::size_t count : {1, 7, 8, 9, 100, 700}) {
    const Soup soup = random_soup(count, random);
    std::vector<std::int32_t> mark(count);
    for (std::int32_t& m : mark) m = random.below(4) == 0 ? 5 : 0;
    for (const PairsWanted& wanted :
         {PairsWanted{}, PairsWanted{static_cast<std::uint32_t>(count / 3), {}},
          PairsWanted{UINT32_MAX, mark},
          PairsWanted{static_cast<std::uint32_t>(count / 2), mark}}) {
      const auto expected = by_trying_all(soup, wanted);
      CHECK(crossing_pairs(soup.positions, soup.triangles, wanted, nullptr) == expected);
      if (count == 700) CHECK_FALSE(expected.empty());
    }
  }
  CHECK(crossing_pairs({}, {}).empty());
}

TEST_CASE("CrossingPairsAreTheSameAtAnyScale") {
  Random random(7);
  Soup soup = random_soup(700, random);
  for (Vec3& p : soup.positions) p = p - Vec3{5e5, 4e6, 100.0};
  const std::vector<TrianglePair> expected = crossing_pairs(soup.positions, soup.triangles);
  REQUIRE_FALSE(expected.empty());
  for (const int exponent : {-200, 200}) {  // far below and above the range of floats
    Soup scaled = soup;
    for (Vec3& p : scaled.positions) p = std::ldexp(1.0, exponent) * p;
    CHECK(crossing_pairs(scaled.positions, scaled.triangles) == expected);
  }
}

TEST_CASE("AMeshCrossesItselfWhereTwoOfItsSheetsDo") {
  TriangleMesh mesh = square_mesh(8);
  CHECK(count_crossing_pairs(mesh) == 0);
  // The same square again on edge, through the first one.
  const auto first = static_cast<std::uint32_t>(mesh.vertices.positions.size());
  const std::size_t triangles = mesh.triangles.size();
  for (std::uint32_t v = 0; v < first; ++v) {
    const Vec3 p = mesh.vertices.positions[v];
    mesh.vertices.positions.push_back({p.x + 0.031, 0.517 + 0.01 * p.x, p.y - 0.47});
  }
  for (std::size_t t = 0; t < triangles; ++t) {
    Triangle moved = mesh.triangles[t];
    for (std::uint32_t& v : moved) v += first;
    mesh.triangles.push_back(moved);
  }
  CHECK(count_crossing_pairs(mesh) >= 14);
}

TEST_CASE("CopiesOfAVertexAreOneWhereCrossingsAreCounted") {
  // Two triangles at one place, each with a vertex of its own.
  TriangleMesh mesh;
  mesh.vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {-1, 0, 0.1}, {0, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  CHECK(count_crossing_pairs(mesh) == 0);
  mesh.vertices.positions[3] = {0.2, 0.2, 0.0};
  CHECK(count_crossing_pairs(mesh) == 1);
}

TEST_CASE("TrianglesAtAVertexThatIsNotFiniteCrossNothing") {
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    TriangleMesh mesh = sphere_mesh(4);
    mesh.vertices.positions[mesh.triangles.back()[0]].y = value;
    CHECK(count_crossing_pairs(mesh) == 0);
  }
}

TEST_CASE("OfPatchesThatCrossTheLaterGoesAndOneThatCrossesTheSurfaceFirst") {
  CHECK(patches_to_drop({}).empty());
  const std::vector<HolePair> surface = {{0, 0}, {0, 4}, {2, 4}, {3, 7}, {5, 5}};
  const DroppedHoles dropped = patches_to_drop(surface);
  CHECK(dropped == DroppedHoles{{4, "every patch crosses the surface"},
                                {5, "every patch crosses itself"},
                                {7, "every patch crosses the patch of hole 3"}});
}

TEST_CASE("PatchesOfHolesThatOverlapLeaveTheLaterOneOpen") {
  // Two bands of spheres that come so close that only the caps which both lack would cross. Their
  // wide borders stay open: of closed objects, triangles around the later cap would be taken out.
  TriangleMesh left = sphere_mesh(5);
  cut(left, [](Vec3 p) { return p.x > 0.85 || p.x < 0.2; });
  TriangleMesh right = sphere_mesh(5);
  cut(right, [](Vec3 p) { return p.x < -0.85 || p.x > -0.2; });
  const TriangleMesh mesh = joined(left, moved(right, [](Vec3 p) {
                                     return p + Vec3{1.9, 0.003, 0.002};
                                   }));
  REQUIRE(count_crossing_pairs(mesh) == 0);
  FillOptions options;
  const FilledMesh filled = fill_mesh(mesh, options);
  REQUIRE(filled.holes.size() == 4);
  CHECK(count_crossing_pairs(filled.mesh) == 0);
  const std::vector<HoleFacts> caps = caps_of(filled);
  REQUIRE(caps.size() == 2);
  CHECK(caps[0].filled);
  CHECK_FALSE(caps[1].filled);
  CHECK(caps[1].reason == "every patch crosses the patch of hole " + std::to_string(caps[0].id));
  options.allow_intersections = true;
  const FilledMesh crossing = fill_mesh(mesh, options);
  CHECK(count_crossing_pairs(crossing.mesh) > 0);
  CHECK(caps_of(crossing)[1].filled);
}
