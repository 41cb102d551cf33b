#include "engine/holes/triangulation/loop_triangulation.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>

#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/triangulation/loop_chords.h"
#include "tests/engine/loops_in_space.h"

using orbweave::CornerTriangle;
using orbweave::facet;
using orbweave::triangulate_loop;
using orbweave::Vec3;
using orbweave::vertex_pair;
using orbweave::VertexPair;
using orbweave::test::cap_rim;
using orbweave::test::Loop;
using orbweave::test::moved;
using orbweave::test::Random;
using orbweave::test::random_loop;
using orbweave::test::wavy_circle;

namespace {

/// How often every pair of mesh vertices is joined by chords (by 2) and rim edges (by 1).
std::map<VertexPair, int> uses(const Loop& loop, const std::vector<CornerTriangle>& triangles) {
  std::map<VertexPair, int> uses;
  for (const CornerTriangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      ++uses[vertex_pair(loop.vertices[t[k]], loop.vertices[t[(k + 1) % 3]])];
    }
  }
  return uses;
}

void require_sound(const Loop& loop, const std::vector<CornerTriangle>& triangles) {
  const std::size_t n = loop.corners.size();
  REQUIRE(triangles.size() == n - 2);
  orbweave::PatchMesh mesh(loop.corners, loop.vertices, triangles, loop.forbidden);
  CHECK(mesh.defect() == "");
  const std::map<VertexPair, int> used = uses(loop, triangles);
  for (const VertexPair& pair : loop.forbidden) CHECK_FALSE(used.contains(pair));
  for (const auto& [pair, count] : used) {
    CHECK(pair[0] != pair[1]);
    CHECK(count <= 2);
  }
}

/// The largest 1 - cos between faces at chords and, where the rim has normals, at the rim.
double largest_bend(const Loop& loop, const std::vector<CornerTriangle>& triangles) {
  const auto n = static_cast<std::uint32_t>(loop.corners.size());
  std::map<VertexPair, std::vector<Vec3>> normals;
  for (std::uint32_t i = 0; i < n && !loop.rim_normals.empty(); ++i) {
    normals[vertex_pair(i, (i + 1) % n)].push_back(loop.rim_normals[i]);
  }
  double largest = 0.0;
  for (const CornerTriangle& t : triangles) {
    const Vec3 normal = facet(loop.corners[t[0]], loop.corners[t[1]], loop.corners[t[2]]).normal;
    if (normal == Vec3{}) largest = 3.0;
    for (int k = 0; k < 3; ++k) normals[vertex_pair(t[k], t[(k + 1) % 3])].push_back(normal);
  }
  for (const auto& [edge, pair] : normals) {
    if (pair.size() == 2) largest = std::max(largest, 1.0 - dot(pair[0], pair[1]));
  }
  return largest;
}

/// Calls `visit` with every triangulation of the corners.
void for_all_triangulations(std::uint32_t corners,
                            const std::function<void(const std::vector<CornerTriangle>&)>& visit) {
  std::vector<CornerTriangle> triangles;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open = {{0, corners - 1}};
  const std::function<void()> next = [&] {
    if (open.empty()) {
      visit(triangles);
      return;
    }
    const auto [i, j] = open.back();
    open.pop_back();
    if (j - i < 2) {
      next();
    } else {
      for (std::uint32_t k = i + 1; k < j; ++k) {
        const auto before = open;
        triangles.push_back({i, k, j});
        open.emplace_back(i, k);
        open.emplace_back(k, j);
        next();
        triangles.pop_back();
        open = before;
      }
    }
    open.emplace_back(i, j);
  };
  next();
}

}  // namespace

TEST_CASE("LeastDihedralAngleOfAllTriangulationsIsFound") {
  Random random(1);
  for (int round = 0; round < 60; ++round) {
    const auto corners = static_cast<std::uint32_t>(3 + random.below(6));
    Loop loop = random_loop(corners, round % 2 == 0 ? 0.2 : 1.0, random);
    if (round % 3 > 0) {
      for (std::uint32_t i = 0; i < corners; ++i) loop.rim_normals.push_back(random.direction());
    }
    const auto found = triangulate_loop(loop.view());
    require_sound(loop, found);
    double least = 4.0;
    for_all_triangulations(corners, [&](const std::vector<CornerTriangle>& triangles) {
      least = std::min(least, largest_bend(loop, triangles));
    });
    CHECK(largest_bend(loop, found) == Approx(least).margin(1e-8));
  }
}

TEST_CASE("LargerLoopsComeCloseToTheLeastDihedralAngle") {
  // Above the size of the exact way an edge's triangle is chosen without the one across it.
  for (const std::uint32_t corners : {24U, 25U, 40U, 160U}) {
    const Loop loop = cap_rim(corners, 0.5);
    CHECK(largest_bend(loop, triangulate_loop(loop.view())) < 1.0 - std::cos(0.55));
  }
}

TEST_CASE("FoldOfFourCornersGoesWhereTheSheetFolds") {
  // A roof whose short ridge runs from corner 0 to 2; the faces around continue its two sides.
  Loop loop;
  loop.corners = {{0, 0, 1}, {0.5, -1, 0}, {1, 0, 1}, {0.5, 1, 0}};
  loop.vertices = {0, 1, 2, 3};
  const Vec3 south = normalized(Vec3{0, -1, 1}), north = normalized(Vec3{0, 1, 1});
  loop.rim_normals = {south, south, north, north};
  auto triangles = triangulate_loop(loop.view());
  std::sort(triangles.begin(), triangles.end());
  REQUIRE(triangles.size() == 2);
  for (const CornerTriangle& t : triangles) {
    CHECK(std::count(t.begin(), t.end(), 0U) == 1);
    CHECK(std::count(t.begin(), t.end(), 2U) == 1);
  }
}

TEST_CASE("CapOfASphereIsClosedOnItsOwnSide") {
  for (const std::uint32_t corners : {5U, 12U, 60U, 300U}) {
    const Loop loop = cap_rim(corners, 0.3);
    const auto triangles = triangulate_loop(loop.view());
    require_sound(loop, triangles);
    // A flat disc: at the rim 0.3 rad or a little more.
    CHECK(largest_bend(loop, triangles) < 1.0 - std::cos(0.35));
    CHECK(orbweave::test::area_of(loop.corners, triangles) <=
          3.1416 * std::sin(0.3) * std::sin(0.3));
  }
}

TEST_CASE("ForbiddenChordsAreNotUsed") {
  Random random(2);
  for (int round = 0; round < 200; ++round) {
    const auto corners = static_cast<std::uint32_t>(4 + random.below(12));
    Loop loop = random_loop(corners, 0.3, random);
    for (std::uint32_t i = 0; i < corners; ++i) {
      for (std::uint32_t j = i + 2; j < corners; ++j) {
        if ((i > 0 || j + 1 < corners) && random.below(3) == 0) loop.forbidden.push_back({i, j});
      }
    }
    const auto triangles = triangulate_loop(loop.view());
    if (!triangles.empty()) require_sound(loop, triangles);
    bool possible = false;
    if (corners > 9) continue;
    for_all_triangulations(corners, [&](const std::vector<CornerTriangle>& other) {
      const auto used = uses(loop, other);
      possible = possible || std::none_of(loop.forbidden.begin(), loop.forbidden.end(),
                                          [&](const VertexPair& p) { return used.contains(p); });
    });
    CHECK(possible == !triangles.empty());
  }
}

TEST_CASE("ForbiddenDiagonalsOfASquareLeaveItOpen") {
  Loop loop = wavy_circle(4, 0.0);
  loop.forbidden = {{0, 2}};
  const std::vector<CornerTriangle> other = triangulate_loop(loop.view());
  require_sound(loop, other);
  loop.forbidden = {{0, 2}, {1, 3}};
  CHECK(triangulate_loop(loop.view()).empty());
}

TEST_CASE("CornersOfOneVertexAreNotJoinedAndNoEdgeIsRepeated") {
  Random random(3);
  int closed = 0;
  for (int round = 0; round < 300; ++round) {
    const auto corners = static_cast<std::uint32_t>(6 + random.below(20));
    Loop loop = random_loop(corners, 0.3, random);
    for (std::uint64_t i = random.below(4) + 1; i > 0; --i) {
      const auto a = static_cast<std::uint32_t>(random.below(corners));
      const auto b = static_cast<std::uint32_t>((a + 2 + random.below(corners - 3)) % corners);
      loop.vertices[b] = loop.vertices[a];
      loop.corners[b] = loop.corners[a];
    }
    bool sound = true;  // no edge of the loop itself from a vertex to itself or twice
    std::map<VertexPair, int> rim;
    for (std::uint32_t i = 0; i < corners; ++i) {
      const VertexPair pair = vertex_pair(loop.vertices[i], loop.vertices[(i + 1) % corners]);
      sound = sound && pair[0] != pair[1] && ++rim[pair] == 1;
    }
    if (!sound) continue;
    const auto triangles = triangulate_loop(loop.view());
    if (triangles.empty()) continue;
    require_sound(loop, triangles);
    ++closed;
  }
  CHECK(closed > 150);
}

TEST_CASE("LargeLoopsAreClosedByEarsFirst") {
  Random random(4);
  for (const std::uint32_t corners : {161U, 500U, 3000U}) {
    const Loop circle = wavy_circle(corners, 0.1);
    require_sound(circle, triangulate_loop(circle.view()));
    // A flat star has no fold: no triangle lies over another.
    Loop star = random_loop(corners, 0.0, random);
    star.rim_normals.assign(corners, {0, 0, 1});
    const auto triangles = triangulate_loop(star.view());
    require_sound(star, triangles);
    CHECK(largest_bend(star, triangles) < 0.5);
  }
}

TEST_CASE("EarsThatCoverAnotherCornerAreCutLast") {
  // A narrow triangle with a spike from below that almost reaches its tip.
  Loop loop;
  loop.corners = {{0, 0, 0}, {3.9, 0, 0}, {4, 18, 0}, {4.1, 0, 0}, {8, 0, 0}, {4, 20, 0}};
  loop.vertices = {0, 1, 2, 3, 4, 5};
  for (const std::vector<Vec3>& normals : {std::vector<Vec3>{}, std::vector<Vec3>(6, {0, 0, 1})}) {
    loop.rim_normals = normals;
    const auto triangles = triangulate_loop(loop.view(), 3);
    require_sound(loop, triangles);
    CHECK(orbweave::test::area_of(loop.corners, triangles) == Approx(80.0 - 1.8));
  }
}

TEST_CASE("EarsComeBeforeTheExactWayAtTheGivenSize") {
  const Loop loop = wavy_circle(40, 0.2);
  for (const std::uint32_t exact : {0U, 3U, 10U, 39U, 40U}) {
    require_sound(loop, triangulate_loop(loop.view(), exact));
  }
}

TEST_CASE("LoopTriangulationDoesNotDependOnUnitsOrPlace") {
  Random random(5);
  for (const std::uint32_t corners : {4U, 7U, 40U, 200U}) {
    Loop loop = random_loop(corners, 0.5, random);
    // Positions that survive the moves exactly.
    for (Vec3& p : loop.corners) {
      for (int axis = 0; axis < 3; ++axis) p[axis] = std::round(p[axis] * 4096.0) / 4096.0;
    }
    const auto expected = triangulate_loop(loop.view());
    const double small = 0x1p-20, large = 0x1p20;
    CHECK(triangulate_loop(moved(loop, small, {}).view()) == expected);
    CHECK(triangulate_loop(moved(loop, large, {}).view()) == expected);
    CHECK(triangulate_loop(moved(loop, 1.0, {500000.0, 5400000.0, 300.0}).view()) == expected);
  }
}

TEST_CASE("CollinearLoopsDoNotBreakTheTriangulation") {
  Loop loop = wavy_circle(9, 0.0);
  for (std::uint32_t i = 0; i < 9; ++i) loop.corners[i] = {0.1 * i * i, 0.2 * i * i, 0.0};
  CHECK(triangulate_loop(loop.view()).size() == 7);
  CHECK(triangulate_loop(loop.view(), 4).size() == 7);
  for (Vec3& p : loop.corners) p = {1.0, 2.0, 3.0};
  CHECK(triangulate_loop(loop.view()).size() == 7);
  for (Vec3& p : loop.corners) p = {NAN, INFINITY, 3.0};
  CHECK(triangulate_loop(loop.view()).size() == 7);
  CHECK(triangulate_loop(loop.view(), 4).size() == 7);
}

TEST_CASE("CollinearCornersOfASquareGetNoFlatTriangles") {
  Loop loop;
  for (int i = 0; i < 4; ++i) loop.corners.push_back({1.0 * i, 0, 0});
  for (int i = 0; i < 4; ++i) loop.corners.push_back({4, 1.0 * i, 0});
  for (int i = 0; i < 4; ++i) loop.corners.push_back({4.0 - i, 4, 0});
  for (int i = 0; i < 4; ++i) loop.corners.push_back({0, 4.0 - i, 0});
  for (std::uint32_t i = 0; i < 16; ++i) loop.vertices.push_back(i);
  for (const std::uint32_t exact : {160U, 5U}) {
    const auto triangles = triangulate_loop(loop.view(), exact);
    require_sound(loop, triangles);
    CHECK(largest_bend(loop, triangles) < 1e-9);
    CHECK(orbweave::test::area_of(loop.corners, triangles) == Approx(16.0));
  }
}

TEST_CASE("LoopsOfFewerThanThreeCornersStayOpen") {
  const Loop loop = wavy_circle(2, 0.0);
  CHECK(triangulate_loop(loop.view()).empty());
  CHECK(triangulate_loop({}).empty());
  const Loop three = wavy_circle(3, 0.0);
  CHECK(triangulate_loop(three.view()) == std::vector<CornerTriangle>{{0, 1, 2}});
}
