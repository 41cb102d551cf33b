#include "engine/cleaning/outliers.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "tests/support/clouds.h"

namespace orbweave {
namespace {

std::vector<std::uint8_t> outliers_of(const std::vector<Vec3>& positions,
                                      const OutlierOptions& options) {
  return find_outliers(positions, 0, static_cast<std::uint32_t>(positions.size()), options);
}

std::size_t count(const std::vector<std::uint8_t>& flags) {
  return static_cast<std::size_t>(std::accumulate(flags.begin(), flags.end(), 0));
}

std::vector<Vec3> in_order(const std::vector<Vec3>& positions) {
  PointCloud cloud;
  cloud.positions = positions;
  test::put_in_order(cloud);
  return cloud.positions;
}

/// A random sheet whose density falls by 1:100 from x = 0 to x = 4.
std::vector<Vec3> sheet_of_varying_density(std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Vec3> points;
  for (int i = 0; i < 200000; ++i) {
    const double x = 4.0 * random.uniform();
    if (random.uniform() > std::pow(10.0, -x / 2.0)) continue;
    points.push_back({x, random.uniform(), 0.001 * random.bell()});
  }
  return points;
}

}  // namespace

TEST_CASE("StraysAreOutliersAndTheSurfaceIsNot") {
  const test::NamedCloud torus = test::noisy_torus(5000, 0.3, 1);
  const double spacing = torus.ball_radius / 1.3;
  std::vector<Vec3> points = torus.cloud.positions;
  const std::size_t surface = points.size();
  // Above the top, apart from each other: a group of strays is its own neighbourhood.
  constexpr std::size_t strays = 6;
  for (const Vec3 around : {Vec3{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}})
    points.push_back(around + Vec3{0, 0, 0.4 + 6.0 * spacing});
  points.push_back({0, 1.4 + 6.0 * spacing, 0});
  points.push_back({0, -1.4 - 6.0 * spacing, 0});
  const auto flags = outliers_of(points, {.sigma = 4.0, .max_radius = 8.0 * spacing});
  const auto on_surface = std::vector(flags.begin(), flags.begin() + static_cast<long>(surface));
  CHECK(count(flags) - count(on_surface) == strays);
  CHECK(count(on_surface) <= surface / 1000);
}

TEST_CASE("DensityThatVariesByAHundredMakesNoOutliers") {
  std::vector<Vec3> points = sheet_of_varying_density(2);
  // Above the dense and above the sparse end, many of the spacings there.
  const std::vector<Vec3> strays = {{0.2, 0.5, 0.1}, {3.7, 0.5, 0.4}};
  points.insert(points.end(), strays.begin(), strays.end());
  points = in_order(points);
  const auto flags = outliers_of(points, {.sigma = 4.0, .max_radius = 0.5});
  std::size_t found = 0, sparse = 0, of_sparse = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::find(strays.begin(), strays.end(), points[i]) != strays.end()) found += flags[i];
    if (points[i].x < 3.0) continue;
    ++sparse;
    of_sparse += flags[i];
  }
  CHECK(found == strays.size());
  CHECK(count(flags) - found <= points.size() / 500);
  // The sparse end alone, where a rule for the whole cloud would take everything.
  REQUIRE(sparse > 500);
  CHECK(of_sparse <= sparse / 50);
}

TEST_CASE("TheBorderOfARegularGridIsNoOutlier") {
  const PointCloud grid = test::grid_sheet(30, 0.0).cloud;
  CHECK(count(outliers_of(grid.positions, {.sigma = 3.0, .max_radius = 6.0})) == 0);
}

TEST_CASE("PointsOfFewerThanThreeNeighborsAreOutliers") {
  std::vector<Vec3> points = test::grid_sheet(12, 0.0).cloud.positions;
  points.push_back({100.0, 0.0, 0.0});
  points.push_back({101.0, 0.0, 0.0});
  points.push_back({100.0, 1.0, 0.0});
  const auto flags = outliers_of(points, {.sigma = 3.0, .max_radius = 6.0});
  CHECK(count(flags) == 3);
  CHECK(outliers_of({}, {.max_radius = 1.0}).empty());
  CHECK(outliers_of({{1, 2, 3}}, {.max_radius = 1.0}) == std::vector<std::uint8_t>{1});
}

TEST_CASE("OutliersDoNotDependOnScale") {
  std::vector<Vec3> points = test::random_sphere(3000, 5).cloud.positions;
  points.push_back({0.0, 0.0, 1.5});
  const OutlierOptions options{.sigma = 2.0, .max_radius = 0.6};
  const auto before = outliers_of(points, options);
  REQUIRE(count(before) > 0);
  for (const int exponent : {-20, 20}) {
    std::vector<Vec3> scaled = points;
    for (Vec3& p : scaled) p = std::ldexp(1.0, exponent) * p;
    CHECK(outliers_of(scaled, {.sigma = 2.0, .max_radius = std::ldexp(0.6, exponent)}) == before);
  }
}

}  // namespace orbweave
