// Strays are found by how far they are from all other points, in extents of these.
#include "partition/strays.h"
#include "partition/count_grid.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "partition/root_cube.h"
#include "tests/partition/clouds.h"

namespace orbweave {
namespace {

CountGrid grid_of(const std::vector<Vec3>& points) {
  CountGrid grid;
  grid.add(points);
  return grid;
}

std::vector<Vec3> sphere(std::size_t points, Vec3 center, double radius) {
  return test::shell(points, center, radius, 11);
}

Box box_of(const std::vector<Vec3>& points) {
  Box box;
  for (const Vec3& p : points) box.extend(p);
  return box;
}

}  // namespace

TEST_CASE("StraysBeyondAHundredExtentsAreLeftOutAndNothingElseIs", "[costly]") {
  // 300,000 points are counted in cells, 3,000 are known as they are.
  for (const std::size_t count : {3000u, 300'000u}) {
    const std::vector<Vec3> body = sphere(count, {7.0, -3.0, 500.0}, 2.0);
    const Box box = box_of(body);
    for (const double away : {1e2, 1e3, 1e7, 1e18, 1e38}) {
      for (const Vec3 direction : {Vec3{1, 0, 0}, Vec3{0, -1, 0}, Vec3{0.3, 1, -0.7}}) {
        INFO(count << " points, a stray " << away << " extents away");
        std::vector<Vec3> points = body;
        const Vec3 stray = body.front() + (away + 1.0) * box.largest_extent() * direction;
        points.push_back(stray);
        const auto kept = box_without_strays(grid_of(points));
        REQUIRE(kept);
        CHECK(!kept->contains(stray));
        CHECK(kept->contains(box.min));
        CHECK(kept->contains(box.max));
      }
    }
  }
}

TEST_CASE("CellsAsWideAsAFarStrayMakesThemTakeNoPointOfTheScan", "[soak]") {
  // More points than are kept as they are, most of them below a power of two and few above it: in
  // the cells of a root cube as wide as the stray is far they lie in different cells.
  constexpr std::size_t kPoints = 300'000;
  for (const double plane : {0.0, 1.0, 4096.0}) {
    for (const double share : {0.001, 0.005, 0.02, 0.5}) {
      const double below = plane - 1.0 + 2.0 * share;
      for (const Vec3 center :
           {Vec3{below, 0.3, 0.4}, Vec3{below, below, below}, Vec3{0.3, 2.0 * plane - below, 0}}) {
        const std::vector<Vec3> body = sphere(kPoints, center, 1.0);
        CHECK(!box_without_strays(grid_of(body)));
        for (const Vec3 stray : {Vec3{1e8, 0, 0}, Vec3{1e18, 0, 0}, Vec3{-1e18, 1e17, 1e18}}) {
          INFO("plane " << plane << ", share " << share << ", stray " << stray.x);
          std::vector<Vec3> points = body;
          points.insert(points.begin() + 1000, stray);
          const auto kept = box_without_strays(grid_of(points));
          REQUIRE(kept);
          CHECK(!kept->contains(stray));
          CHECK(std::all_of(body.begin(), body.end(), [&](Vec3 p) { return kept->contains(p); }));
        }
      }
    }
  }
}

TEST_CASE("WhatWideCellsHideIsFoundOnceTheFarthestStraysAreGone", "[costly]") {
  const std::vector<Vec3> body = sphere(300'000, {-0.95, 0.2, 0.1}, 1.0);
  std::vector<Vec3> points = body;
  for (const double away : {1e3, 1e7, 1e12, 1e18, 1e30}) points.push_back({away, -away, 0.0});
  for (int pass = 0; pass < 5; ++pass) {
    const auto kept = box_without_strays(grid_of(points));
    if (!kept) break;
    const std::size_t before = points.size();
    std::erase_if(points, [&](Vec3 p) { return !kept->contains(p); });
    REQUIRE(points.size() < before);
  }
  CHECK((points == body));
}

TEST_CASE("HowExactlyPlacesAreKnownDependsOnTheNumberOfPointsAlone", "[costly]") {
  // Whole batches of one point come first, last or in between.
  const std::vector<Vec3> equal(200'000, Vec3{1, 2, 3});
  const std::vector<Vec3> others = sphere(100'000, {1, 2, 3}, 1.0);
  const auto places = [](std::vector<const std::vector<Vec3>*> batches) {
    CountGrid grid;
    for (const auto* batch : batches) grid.add(*batch);
    std::map<std::pair<std::array<double, 3>, double>, std::uint64_t> counts;
    grid.for_each_place([&](Vec3 corner, double side, std::uint64_t count) {
      counts[{{corner.x, corner.y, corner.z}, side}] += count;
    });
    return counts;
  };
  const auto expected = places({&others, &equal});
  CHECK(expected.begin()->first.second > 0.0);
  CHECK((places({&equal, &others}) == expected));
  const std::vector<Vec3> few(others.begin(), others.begin() + 50'000);
  const auto exact = places({&few, &equal});
  CHECK(exact.begin()->first.second == 0.0);
  CHECK((places({&equal, &few}) == exact));
}

TEST_CASE("PointsTenExtentsAwayAreNoStrays", "[costly]") {
  for (const std::size_t count : {20u, 3000u, 300'000u}) {
    std::vector<Vec3> points = sphere(count, {}, 1.0);
    for (const double away : {1.0, 10.0, 30.0}) {
      points.push_back({2.0 * away, 0.0, 0.0});
      CHECK(!box_without_strays(grid_of(points)));
    }
  }
}

TEST_CASE("LargeGroupsAreNoStraysHoweverFarAway") {
  for (const double share : {0.02, 0.3, 0.5}) {
    std::vector<Vec3> points = sphere(2000, {}, 1.0);
    const auto others = sphere(static_cast<std::size_t>(2000 * share), {1e9, 0.0, 0.0}, 1.0);
    points.insert(points.end(), others.begin(), others.end());
    CHECK(!box_without_strays(grid_of(points)));
  }
}

TEST_CASE("StraysOnAllSidesAndAtAllDistancesAreLeftOutTogether") {
  std::vector<Vec3> points = sphere(5000, {1.0, 2.0, 3.0}, 1.0);
  const Box box = box_of(points);
  for (const double away : {300.0, 1e5, 1e9, 1e20})
    for (const double side : {-1.0, 1.0})
      points.insert(points.end(), {{side * away, 0, 0}, {0, side * away, 0}, {0, 0, side * away}});
  const auto kept = box_without_strays(grid_of(points));
  REQUIRE(kept);
  std::size_t inside = 0;
  for (const Vec3& p : points) inside += kept->contains(p) ? 1 : 0;
  CHECK(inside == 5000);
  CHECK(kept->contains(box.min));
}

TEST_CASE("SparseSurroundingsBelongToTheBody") {
  // As dense as 1 / distance^3: every doubling of the distance holds as many points.
  std::vector<Vec3> points;
  for (int i = 0; i < 20'000; ++i) {
    const double distance = std::exp2(40.0 * i / 20'000.0);
    points.push_back({distance * std::cos(i), distance * std::sin(i), distance * std::cos(3 * i)});
  }
  CHECK(!box_without_strays(grid_of(points)));
}

TEST_CASE("DegenerateCloudsHaveNoStrays") {
  CHECK(!box_without_strays(grid_of({})));
  CHECK(!box_without_strays(grid_of({{1, 2, 3}})));
  CHECK(!box_without_strays(grid_of({{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}})));
  CHECK(!box_without_strays(grid_of({{0, 0, 0}, {1e9, 0, 0}})));
  CHECK(!box_without_strays(grid_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e9, 0, 0}})));
}

TEST_CASE("CornersOfAnOctahedronAreNoStrays") {
  // Along each axis all but the two outermost points lie at the middle.
  std::vector<Vec3> points = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  CHECK(!box_without_strays(grid_of(points)));
  points.push_back({0, 0, 0});
  CHECK(!box_without_strays(grid_of(points)));
}

TEST_CASE("CellsLargerThanTheirCloudAreCornersOfTheSameLattice") {
  // A dense chunk of a wide root cube is counted in cells of that cube.
  const std::vector<Vec3> points = sphere(1000, {0.7, 0.3, 0.1}, 0.3);
  for (const double cell : {0x1p-10, 1.0, 8.0, 0x1p40, 0x1p400}) {
    CountGrid grid(CountGrid::kUsualLimitBytes, cell);
    grid.add(points);
    std::uint64_t counted = 0;
    grid.for_each([&](Vec3 corner, std::uint64_t count) {
      for (int axis = 0; axis < 3; ++axis) CHECK(std::fmod(corner[axis], grid.cell()) == 0.0);
      counted += count;
    });
    CHECK(grid.cell() >= cell);
    CHECK(counted == points.size());
    CountGrid lone(CountGrid::kUsualLimitBytes, cell);
    lone.add(std::vector<Vec3>(10, points.front()));
    CHECK(lone.cell() >= cell);
  }
}

}  // namespace orbweave
