#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/patch/patch_defect.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/holes/fill_hole.h"
#include "engine/holes/triangulation/loop_chords.h"
#include "tests/engine/loops_in_space.h"

using orbweave::CornerTriangle;
using orbweave::PatchMesh;
using orbweave::RimSheet;
using orbweave::triangulate_loop;
using orbweave::Vec3;
using orbweave::vertex_pair;
using orbweave::VertexPair;
using orbweave::test::area_of;
using orbweave::test::Loop;
using orbweave::test::moved;
using orbweave::test::Random;
using orbweave::test::random_loop;
using orbweave::test::wavy_circle;

namespace {

PatchMesh disc_of(const Loop& loop) {
  return PatchMesh(loop.corners, loop.vertices, triangulate_loop(loop.view()), loop.forbidden);
}

/// The patch as fill_hole would return it, judged by patch_defect.
std::string defect_as_patch(const PatchMesh& mesh, const Loop& loop) {
  orbweave::HoleProblem problem;
  const std::uint32_t given = 1 + *std::max_element(loop.vertices.begin(), loop.vertices.end());
  problem.positions.resize(given);
  problem.loop = loop.vertices;
  problem.forbidden = loop.forbidden;
  std::vector<std::uint32_t> number(mesh.size());
  std::copy(loop.vertices.begin(), loop.vertices.end(), number.begin());
  orbweave::HolePatch patch;
  patch.method = orbweave::FillMethod::kDirect;
  patch.triangles = mesh.triangles();
  std::vector<char> used(mesh.size(), 0);
  for (const CornerTriangle& t : patch.triangles) {
    for (const std::uint32_t v : t) used[v] = 1;
  }
  for (std::uint32_t v = mesh.corners(); v < mesh.size(); ++v) {
    if (used[v] == 0) continue;
    number[v] = given + static_cast<std::uint32_t>(patch.positions.size());
    patch.positions.push_back(mesh.positions()[v]);
    patch.normals.push_back({0, 0, 1});
  }
  for (CornerTriangle& t : patch.triangles) {
    for (std::uint32_t& v : t) v = number[v];
  }
  return orbweave::patch_defect(problem, patch);
}

void require_sound(const PatchMesh& mesh, const Loop& loop) {
  REQUIRE(mesh.defect() == "");
  REQUIRE(defect_as_patch(mesh, loop) == "");
}

struct Edges {
  std::vector<double> inside, rim;
};

Edges edge_lengths(const PatchMesh& mesh) {
  Edges lengths;
  const auto& p = mesh.positions();
  for (const CornerTriangle& t : mesh.triangles()) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      const bool rim = a < mesh.corners() && b == (a + 1) % mesh.corners();
      if (rim || a < b) (rim ? lengths.rim : lengths.inside).push_back(norm(p[b] - p[a]));
    }
  }
  return lengths;
}

double longest_inside(const PatchMesh& mesh) {
  const Edges lengths = edge_lengths(mesh);
  return lengths.inside.empty() ? 0.0
                                : *std::max_element(lengths.inside.begin(), lengths.inside.end());
}

/// The largest sum of opposite angles of an edge inside.
double largest_angle_sum(const PatchMesh& mesh) {
  orbweave::HalfEdges half;
  REQUIRE(half.assign(mesh.triangles(), mesh.size()));
  const auto angle = [&](std::uint32_t h) {
    const Vec3 c = mesh.positions()[half.apex(h)];
    const Vec3 u = mesh.positions()[half.origin[h]] - c;
    const Vec3 v = mesh.positions()[half.target(h)] - c;
    return std::atan2(norm(cross(u, v)), dot(u, v));
  };
  double largest = 0.0;
  for (std::uint32_t h = 0; h < half.size(); ++h) {
    if (half.twin[h] != orbweave::kNone32)
      largest = std::max(largest, angle(h) + angle(half.twin[h]));
  }
  return largest;
}

/// A loop that visits vertices several times, with forbidden chords; its rim edges are sound.
Loop touching_loop(std::uint32_t corners, Random& random) {
  Loop loop = random_loop(corners, 0.3, random);
  for (int i = 0; i < 3; ++i) {
    const auto a = static_cast<std::uint32_t>(random.below(corners));
    const auto b = static_cast<std::uint32_t>((a + 3 + random.below(corners - 5)) % corners);
    const auto same_neighbor = [&] {
      const auto at = [&](std::uint32_t j) { return loop.vertices[j % corners]; };
      if (at(b + 1) == a || at(b + corners - 1) == a) return true;
      for (const std::uint32_t x : {at(a + 1), at(a + corners - 1)}) {
        for (const std::uint32_t y : {at(b + 1), at(b + corners - 1)}) {
          if (x == y) return true;
        }
      }
      return false;
    };
    if (loop.vertices[a] != a || loop.vertices[b] != b || same_neighbor()) continue;
    loop.vertices[b] = a;
    loop.corners[b] = loop.corners[a];
  }
  for (std::uint32_t i = 0; i < corners; ++i) {
    const VertexPair pair =
        vertex_pair(loop.vertices[i], loop.vertices[(i + 2 + random.below(corners - 3)) % corners]);
    if (random.below(4) == 0 && pair[0] != pair[1]) loop.forbidden.push_back(pair);
  }
  // Rim edges are in use but not to be judged as chords.
  std::vector<VertexPair> rim;
  for (std::uint32_t i = 0; i < corners; ++i) {
    rim.push_back(vertex_pair(loop.vertices[i], loop.vertices[(i + 1) % corners]));
  }
  std::sort(rim.begin(), rim.end());
  std::erase_if(loop.forbidden,
                [&](const VertexPair& p) { return std::binary_search(rim.begin(), rim.end(), p); });
  std::sort(loop.forbidden.begin(), loop.forbidden.end());
  return loop;
}

/// A fan from one corner, whatever its chords are.
PatchMesh fan_of(const Loop& loop, std::uint32_t from) {
  const auto n = static_cast<std::uint32_t>(loop.corners.size());
  std::vector<CornerTriangle> triangles;
  for (std::uint32_t i = 1; i + 1 < n; ++i) {
    triangles.push_back({from, (from + i) % n, (from + i + 1) % n});
  }
  return PatchMesh(loop.corners, loop.vertices, triangles, loop.forbidden);
}

/// A sheet between a loop and a ring of as many points around it.
RimSheet strip_across(const std::vector<Vec3>& ring) {
  const auto n = static_cast<std::uint32_t>(ring.size());
  RimSheet sheet{ring, {}, std::vector<char>(n, 1)};
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    sheet.triangles.push_back({next, i, n + i});
    sheet.triangles.push_back({next, n + i, n + next});
  }
  return sheet;
}

}  // namespace

TEST_CASE("EveryOperationKeepsThePatchSound", "[costly]") {
  Random random(1);
  for (int round = 0; round < 150; ++round) {
    const auto corners = static_cast<std::uint32_t>(8 + random.below(40));
    const Loop loop = touching_loop(corners, random);
    PatchMesh mesh = fan_of(loop, static_cast<std::uint32_t>(random.below(corners)));
    mesh.split_forbidden_chords();
    require_sound(mesh, loop);
    for (int step = 0; step < 8; ++step) {
      const double length = 0.02 + 0.3 * random.uniform();
      switch (random.below(5)) {
        case 0:
          mesh.split_long_edges(length, 500);
          break;
        case 1:
          mesh.collapse_short_edges(length);
          break;
        case 2:
          mesh.flip_to_delaunay();
          break;
        case 3:
          mesh.smooth(1 + static_cast<int>(random.below(2)));
          break;
        default:
          mesh.split_forbidden_chords();
          break;
      }
      require_sound(mesh, loop);
      CHECK(std::all_of(mesh.positions().begin(), mesh.positions().end(), orbweave::is_finite));
      CHECK(std::equal(loop.corners.begin(), loop.corners.end(), mesh.positions().begin()));
    }
  }
}

TEST_CASE("ForbiddenChordsAreSplitAndNothingElse") {
  Loop loop = wavy_circle(6, 0.1);
  PatchMesh mesh = fan_of(loop, 0);
  CHECK(mesh.split_forbidden_chords() == 0);
  CHECK(mesh.size() == 6);
  loop.forbidden = {{0, 2}, {0, 4}, {1, 3}};
  mesh = fan_of(loop, 0);
  CHECK(mesh.split_forbidden_chords() == 2);
  require_sound(mesh, loop);
  CHECK(mesh.positions()[6] == 0.5 * (loop.corners[0] + loop.corners[2]));
}

TEST_CASE("ChordThatJoinsCornersOfOneVertexIsSplitUntilNoEdgeRepeats") {
  // A hourglass: corners 0 and 3 are one vertex, and the fan joins them.
  Loop loop = wavy_circle(6, 0.0);
  loop.vertices[3] = 0;
  loop.corners[3] = loop.corners[0];
  PatchMesh mesh = fan_of(loop, 0);
  CHECK(mesh.split_forbidden_chords() > 0);
  require_sound(mesh, loop);
}

TEST_CASE("RefinedDiscsHaveTheSpacingAskedFor") {
  for (const std::uint32_t corners : {5U, 12U, 60U, 200U, 400U}) {
    const Loop loop = wavy_circle(corners, 0.0);
    const double spacing = norm(loop.corners[1] - loop.corners[0]);
    PatchMesh mesh = disc_of(loop);
    const std::uint32_t points = mesh.split_long_edges(1.4 * spacing, 1'000'000);
    CHECK(points == mesh.size() - mesh.corners());
    require_sound(mesh, loop);
    CHECK(longest_inside(mesh) <= 1.4 * spacing * 1.1);
    CHECK(area_of(mesh.positions(), mesh.triangles()) ==
          Approx(area_of(loop.corners, triangulate_loop(loop.view()))));
    // A hexagonal grid of that spacing has area / (sqrt(3/4) spacing^2) points.
    const double expected = 3.14159 / (std::sqrt(0.75) * spacing * spacing);
    CHECK(points < 1.6 * expected);
    if (corners >= 60) CHECK(points > 0.4 * expected);
  }
}

TEST_CASE("LongRimEdgesDoNotKeepRefinementFromEnding") {
  Loop loop = wavy_circle(64, 0.0);
  loop.corners[0] = {4, 0, 0};  // two edges of 40 spacings
  PatchMesh one = disc_of(loop);
  CHECK(one.split_long_edges(0.1, 100'000) < 2000);
  require_sound(one, loop);
  // All edges of the rim are long: six of 0.1 and more to each of them.
  loop = wavy_circle(10, 0.1);
  PatchMesh all = disc_of(loop);
  const std::uint32_t points = all.split_long_edges(0.1, 100'000);
  CHECK(points > 300);
  CHECK(points < 1000);
  require_sound(all, loop);
}

TEST_CASE("RefinementStopsAtTheMostPoints") {
  const Loop loop = wavy_circle(50, 0.2);
  for (const std::uint32_t most : {0U, 1U, 7U, 100U}) {
    PatchMesh mesh = disc_of(loop);
    CHECK(mesh.split_long_edges(0.05, most) <= most);
    CHECK(mesh.size() <= 50 + most);
    require_sound(mesh, loop);
  }
}

TEST_CASE("FlatPatchesBecomeDelaunay") {
  Random random(2);
  for (int round = 0; round < 20; ++round) {
    const Loop loop = wavy_circle(static_cast<std::uint32_t>(5 + random.below(60)), 0.0);
    PatchMesh mesh = fan_of(loop, 0);
    mesh.split_long_edges(0.3, 1000);
    mesh.flip_to_delaunay();
    CHECK(largest_angle_sum(mesh) <= 3.14159266);
    CHECK(mesh.flip_to_delaunay() == 0);
    require_sound(mesh, loop);
  }
}

TEST_CASE("FlipsKeepOffForbiddenAndExistingEdges") {
  // A flat quad whose Delaunay diagonal is 1-3.
  Loop loop;
  loop.corners = {{0, 0, 0}, {2, -0.5, 0}, {4, 0, 0}, {2, 0.5, 0}};
  loop.vertices = {0, 1, 2, 3};
  const std::vector<CornerTriangle> wide = {{0, 1, 2}, {0, 2, 3}};
  PatchMesh free(loop.corners, loop.vertices, wide, {});
  CHECK(free.flip_to_delaunay() == 1);
  loop.forbidden = {{1, 3}};
  PatchMesh held(loop.corners, loop.vertices, wide, loop.forbidden);
  CHECK(held.flip_to_delaunay() == 0);
  PatchMesh same(loop.corners, std::vector<std::uint32_t>{0, 1, 2, 1}, wide, {});
  CHECK(same.flip_to_delaunay() == 0);
}

TEST_CASE("FlipsDoNotTurnFacesOverOrSharpenCreases") {
  Random random(7);
  int flips = 0;
  for (int round = 0; round < 20000; ++round) {
    Loop loop;
    for (std::uint32_t i = 0; i < 4; ++i) {
      loop.corners.push_back({random.uniform(), random.uniform(), random.uniform()});
      loop.vertices.push_back(i);
    }
    PatchMesh mesh(loop.corners, loop.vertices, std::vector<CornerTriangle>{{0, 1, 2}, {0, 2, 3}},
                   {});
    if (mesh.flip_to_delaunay() == 0) continue;
    ++flips;
    const auto& p = loop.corners;
    const Vec3 a = cross(p[1] - p[0], p[2] - p[0]), b = cross(p[2] - p[0], p[3] - p[0]);
    const Vec3 c = cross(p[1] - p[0], p[3] - p[0]), d = cross(p[2] - p[1], p[3] - p[1]);
    CHECK(dot(c, a + b) > 0.0);
    CHECK(dot(d, a + b) > 0.0);
    const double before = dot(normalized(a), normalized(b));
    CHECK(dot(normalized(c), normalized(d)) > std::min(before, 0.5) - 1e-9);
  }
  CHECK(flips > 1000);
}

TEST_CASE("ShortEdgesAreCollapsed") {
  const Loop loop = wavy_circle(100, 0.0);
  PatchMesh mesh = disc_of(loop);
  mesh.split_long_edges(0.05, 100'000);
  const std::size_t before = mesh.triangles().size();
  const std::uint32_t gone = mesh.collapse_short_edges(0.1);
  CHECK(gone > 500);
  CHECK(mesh.triangles().size() == before - 2 * gone);
  require_sound(mesh, loop);
  const Edges lengths = edge_lengths(mesh);
  CHECK(std::count_if(lengths.inside.begin(), lengths.inside.end(), [](double length) {
          return length < 0.1;
        }) < static_cast<std::ptrdiff_t>(lengths.inside.size() / 20));
  const std::vector<CornerTriangle> triangles = mesh.triangles();
  CHECK(std::all_of(triangles.begin(), triangles.end(), [&](const CornerTriangle& t) {
    const auto& p = mesh.positions();
    return cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]).z > 0.0;
  }));
}

TEST_CASE("NeighborsAreThoseOfTheTriangles") {
  const Loop loop = wavy_circle(5, 0.0);
  PatchMesh mesh(loop.corners, loop.vertices,
                 std::vector<CornerTriangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}, {});
  const std::vector<std::vector<std::uint32_t>> expected = {
      {1, 2, 3, 4}, {0, 2}, {0, 1, 3}, {0, 2, 4}, {0, 3}};
  CHECK(mesh.neighbors() == expected);
}

TEST_CASE("WhatIsNoDiscIsSeen") {
  const Loop loop = wavy_circle(4, 0.0);
  const auto made_of = [&](std::vector<CornerTriangle> triangles, std::size_t inner = 0) {
    std::vector<Vec3> positions = loop.corners;
    positions.resize(4 + inner);
    return PatchMesh(positions, loop.vertices, triangles, {}).defect();
  };
  CHECK(made_of({{0, 1, 2}, {0, 2, 3}}) == "");
  CHECK(made_of({}) == "no triangles");
  CHECK(made_of({{0, 1, 2}, {0, 1, 2}}) == "no triangles");
  CHECK(made_of({{0, 1, 9}, {1, 2, 3}}) == "no triangles");
  CHECK(made_of({{0, 1, 2}}) == "a boundary that is not the loop");
  CHECK(made_of({{0, 2, 1}, {0, 3, 2}}) == "a boundary that is not the loop");
  CHECK(made_of({{0, 1, 2}, {0, 2, 2}}) != "");
  CHECK(made_of({{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}, {5, 7, 6}, {4, 7, 5}}, 4) ==
        "not one disc");
  CHECK(
      made_of(
          {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {4, 5, 6}, {4, 6, 7}, {5, 7, 6}, {4, 7, 5}},
          4) == "a vertex of several fans");
}

TEST_CASE("FlatPatchStaysFlatHoweverItIsSmoothed") {
  Random random(3);
  Loop loop = random_loop(40, 0.0, random);
  for (const int order : {1, 2}) {
    PatchMesh mesh = disc_of(loop);
    mesh.split_long_edges(0.1, 10'000);
    for (std::uint32_t v = mesh.corners(); v < mesh.size(); ++v) {
      mesh.positions()[v].z = 0.1 * random.bell();
    }
    std::vector<Vec3> ring;
    for (const Vec3& p : loop.corners) ring.push_back(1.1 * p);
    mesh.smooth(order, order == 2 ? strip_across(ring) : RimSheet{});
    for (const Vec3& p : mesh.positions()) CHECK(std::abs(p.z) < 1e-9);
  }
}

TEST_CASE("MembraneStaysWithinTheRimsBox") {
  Random random(4);
  const Loop loop = random_loop(50, 0.5, random);
  PatchMesh mesh = disc_of(loop);
  mesh.split_long_edges(0.08, 10'000);
  mesh.smooth(1);
  for (int axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax_element(loop.corners.begin(), loop.corners.end(),
                                                 [&](Vec3 a, Vec3 b) { return a[axis] < b[axis]; });
    for (const Vec3& p : mesh.positions()) {
      CHECK(p[axis] >= (*low)[axis] - 1e-9);
      CHECK(p[axis] <= (*high)[axis] + 1e-9);
    }
  }
}

TEST_CASE("PlateThatKnowsTheSheetContinuesASphere") {
  constexpr double kAngle = 0.6;
  constexpr std::uint32_t kCorners = 60;
  const Loop loop = orbweave::test::cap_rim(kCorners, kAngle);
  const double spacing = norm(loop.corners[1] - loop.corners[0]);
  const std::vector<Vec3> ring = orbweave::test::cap_rim(kCorners, kAngle + spacing).corners;
  const auto largest_error = [&](int order, const RimSheet& across) {
    PatchMesh mesh = disc_of(loop);
    for (int round = 0; round < 3; ++round) {
      mesh.split_long_edges(1.4 * spacing, 10'000);
      mesh.flip_to_delaunay();
      mesh.smooth(round == 0 ? 1 : order, across);
    }
    double error = 0.0;
    for (const Vec3& p : mesh.positions()) error = std::max(error, std::abs(norm(p) - 1.0));
    return error;
  };
  const double height = 1.0 - std::cos(kAngle);
  CHECK(largest_error(1, {}) > 0.8 * height);
  CHECK(largest_error(2, strip_across(ring)) < 0.1 * height);
}

TEST_CASE("RefinementDoesNotDependOnUnits") {
  Random random(5);
  const Loop loop = random_loop(30, 0.4, random);
  const auto refined = [&](double scale) {
    const Loop there = moved(loop, scale, {});
    PatchMesh mesh = disc_of(there);
    mesh.split_long_edges(0.2 * scale, 1000);
    mesh.collapse_short_edges(0.08 * scale);
    mesh.flip_to_delaunay();
    return mesh.triangles();
  };
  // Powers of two, which round nothing.
  CHECK(refined(0x1p-20) == refined(1.0));
  CHECK(refined(0x1p20) == refined(1.0));
}

TEST_CASE("SmoothingDoesNotDependOnUnitsOrPlace") {
  Random random(5);
  const Loop loop = random_loop(30, 0.4, random);
  PatchMesh start = disc_of(loop);
  start.split_long_edges(0.2, 1000);
  REQUIRE(start.size() > 50);
  for (const int order : {1, 2}) {
    const auto smoothed = [&](double scale, Vec3 offset) {
      PatchMesh mesh = start;
      for (Vec3& p : mesh.positions()) p = scale * p + offset;
      mesh.smooth(order);
      for (Vec3& p : mesh.positions()) p = (p - offset) / scale;
      return mesh.positions();
    };
    const std::vector<Vec3> expected = smoothed(1.0, {});
    CHECK(expected != start.positions());
    const auto largest_difference = [&](const std::vector<Vec3>& found) {
      double largest = 0.0;
      for (std::size_t v = 0; v < found.size(); ++v) {
        largest = std::max(largest, norm(found[v] - expected[v]));
      }
      return largest;
    };
    CHECK(largest_difference(smoothed(1e-6, {})) < 1e-9);
    CHECK(largest_difference(smoothed(1e6, {})) < 1e-9);
    CHECK(largest_difference(smoothed(1.0, {500000.0, 5400000.0, 300.0})) < 1e-6);
  }
}

TEST_CASE("OperationsArePureFunctionsOfThePatch") {
  const auto made = [] {
    Random random(6);
    const Loop loop = touching_loop(40, random);
    PatchMesh mesh = fan_of(loop, 3);
    mesh.split_forbidden_chords();
    mesh.split_long_edges(0.1, 1000);
    mesh.flip_to_delaunay();
    mesh.collapse_short_edges(0.06);
    mesh.smooth(2);
    return mesh;
  };
  const PatchMesh a = made(), b = made();
  CHECK(a.positions() == b.positions());
  CHECK(a.triangles() == b.triangles());
}

TEST_CASE("PatchesWithoutSenseDoNotBreakTheOperations") {
  Loop loop = wavy_circle(8, 0.0);
  for (const double bad : {0.0, 1e308, static_cast<double>(INFINITY), static_cast<double>(NAN)}) {
    PatchMesh mesh = disc_of(loop);
    mesh.split_long_edges(0.3, 100);
    for (Vec3& p : mesh.positions()) p = {bad, -bad, bad};
    mesh.split_long_edges(0.1, 100);
    mesh.flip_to_delaunay();
    mesh.collapse_short_edges(0.2);
    mesh.smooth(1);
    mesh.smooth(2, strip_across(loop.corners));
    CHECK(mesh.defect() == "");
  }
}
