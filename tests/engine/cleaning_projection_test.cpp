#include "engine/cleaning/projection.h"
#include "engine/geometry/neighbor_grid.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/clouds.h"

namespace orbweave {
namespace {

/// Unit sphere of random points with noise along the normals, given as in `noise` (deviation).
PointCloud noisy_sphere(std::size_t points, double noise, std::uint64_t seed) {
  PointCloud cloud = test::random_sphere(points, seed).cloud;
  test::Random random(seed + 1);
  for (Vec3& p : cloud.positions) p = (1.0 + 3.0 * noise * random.bell()) * p;
  return cloud;
}

struct Deviation {
  double mean = 0.0;
  double deviation = 0.0;
};

Deviation from_unit_sphere(const std::vector<Vec3>& points) {
  Deviation result;
  double squares = 0.0;
  const auto n = static_cast<double>(points.size());
  for (const Vec3& p : points) {
    result.mean += (norm(p) - 1.0) / n;
    squares += (norm(p) - 1.0) * (norm(p) - 1.0) / n;
  }
  result.deviation = std::sqrt(squares);
  return result;
}

PointCloud projected(PointCloud cloud, double radius, int passes, bool oriented = true) {
  for (int pass = 0; pass < passes; ++pass) {
    const auto n = static_cast<std::uint32_t>(cloud.size());
    ProjectedPoints result =
        project_points(cloud.positions, cloud.normals, 0, n, {radius, oriented});
    cloud.positions = std::move(result.positions);
    cloud.normals = std::move(result.normals);
  }
  return cloud;
}

}  // namespace

TEST_CASE("ProjectionRemovesNoiseAndDoesNotShrinkTheSphere") {
  const double noise = 0.01;
  const PointCloud before = noisy_sphere(20000, noise, 1);
  REQUIRE(from_unit_sphere(before.positions).deviation == Approx(noise).epsilon(0.05));
  for (const bool oriented : {true, false}) {
    const PointCloud after = projected(before, 0.2, 2, oriented);
    const Deviation left = from_unit_sphere(after.positions);
    INFO("deviation " << left.deviation << ", mean " << left.mean);
    CHECK(left.deviation < noise / 4.0);
    // A plane instead of a quadric would lose 0.0025 to 0.005 here.
    CHECK(std::abs(left.mean) < 0.0003);
    for (std::size_t i = 0; i < after.size(); ++i) {
      REQUIRE(norm(after.normals[i]) == Approx(1.0));
      REQUIRE(dot(after.normals[i], before.normals[i]) > 0.9);
    }
  }
}

TEST_CASE("ProjectionLeavesACleanSurfaceWhereItIs") {
  const PointCloud before = test::random_sphere(20000, 4).cloud;
  const Deviation left = from_unit_sphere(projected(before, 0.15, 1).positions);
  CHECK(left.deviation < 0.15 * 0.15 * 0.15 * 0.05);
}

TEST_CASE("WrongNormalsTakeTheDirectionOfThoseAround") {
  PointCloud cloud = noisy_sphere(10000, 0.005, 6);
  const std::vector<Vec3> truth = cloud.normals;
  test::Random random(8);
  for (Vec3& normal : cloud.normals)
    if (random.uniform() < 0.1) normal = random.direction();
  const PointCloud after = projected(cloud, 0.2, 1);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < after.size(); ++i) wrong += dot(after.normals[i], truth[i]) < 0.95;
  CHECK(wrong == 0);
}

TEST_CASE("TheTwoSidesOfAThinWallStayApart") {
  // Sheets that are a third of the radius apart, with noise.
  PointCloud wall = test::grid_sheet(40, 1.2).cloud;
  test::Random random(3);
  for (Vec3& p : wall.positions) p.z += 0.3 * random.bell();
  const PointCloud after = projected(wall, 3.6, 2);
  double worst = 0.0;
  for (std::size_t i = 0; i < wall.size(); ++i) {
    const bool above = wall.normals[i].z > 0.0;
    const Vec3 p = wall.positions[i];
    if (p.x < 4 || p.x > 35 || p.y < 4 || p.y > 35) continue;
    worst = std::max(worst, std::abs(after.positions[i].z - (above ? 0.0 : -1.2)));
    REQUIRE((after.normals[i].z > 0.0) == above);
  }
  CHECK(worst < 0.15);
}

TEST_CASE("FacesKeepTheirPlaceAndNormalUpToTheirEdge") {
  // Two faces of a cube: z = 0 for x >= 0 and x = 0 for z < 0.
  PointCloud cloud = test::grid_sheet(24, 0.0).cloud;
  const std::size_t top = cloud.size();
  for (std::size_t i = 0; i < top; ++i) {
    const Vec3 p = cloud.positions[i];
    cloud.positions.push_back({0.0, p.y, -p.x - 1.0});
    cloud.normals.push_back({-1.0, 0.0, 0.0});
  }
  const double radius = 4.0;
  const auto n = static_cast<std::uint32_t>(cloud.size());
  const auto result = project_points(cloud.positions, cloud.normals, 0, n, {radius, true});
  double worst_move = 0.0, worst_cosine = 1.0;
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec3 p = cloud.positions[i];
    if (std::max(p.x, -p.z) < 0.5 * radius) continue;
    worst_move = std::max(worst_move, norm(result.positions[i] - p));
    worst_cosine = std::min(worst_cosine, dot(result.normals[i], cloud.normals[i]));
  }
  INFO("move " << worst_move << ", cosine " << worst_cosine);
  CHECK(worst_move < 0.01 * radius);
  CHECK(worst_cosine > 0.99);
}

TEST_CASE("PointsWithoutNormalOrNeighborsStay") {
  PointCloud cloud = noisy_sphere(5000, 0.005, 2);
  cloud.normals[17] = {};
  cloud.positions.push_back({3.0, 0.0, 0.0});
  cloud.normals.push_back({1.0, 0.0, 0.0});
  const auto n = static_cast<std::uint32_t>(cloud.size());
  const auto result = project_points(cloud.positions, cloud.normals, 0, n, {0.2, true});
  for (const std::uint32_t still : {17u, n - 1}) {
    CHECK(result.moved[still] == 0);
    CHECK(result.positions[still] == cloud.positions[still]);
    CHECK(result.normals[still] == cloud.normals[still]);
  }
  CHECK(std::count(result.moved.begin(), result.moved.end(), 0) == 2);
}

TEST_CASE("PointsThatAreNotChosenStayAndTheOthersMoveAsIfAllWere") {
  const PointCloud cloud = noisy_sphere(5000, 0.01, 3);
  const auto n = static_cast<std::uint32_t>(cloud.size());
  const std::uint32_t begin = 100, end = n - 700;
  std::vector<std::uint8_t> chosen(end - begin);
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = i % 3 == 0 ? 1 : 0;
  const auto all = project_points(cloud.positions, cloud.normals, begin, end, {0.2, true});
  const auto some = project_points(cloud.positions, cloud.normals, begin, end, {0.2, true}, chosen);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    CHECK(some.moved[i] == chosen[i]);
    CHECK(some.positions[i] == (chosen[i] ? all.positions[i] : cloud.positions[begin + i]));
    CHECK(some.normals[i] == (chosen[i] ? all.normals[i] : cloud.normals[begin + i]));
  }
}

TEST_CASE("NothingMovesFartherThanTheRadius") {
  const PointCloud ball = test::random_ball(4000, 5).cloud;
  const auto n = static_cast<std::uint32_t>(ball.size());
  std::vector<Vec3> normals = ball.normals;
  for (Vec3& normal : normals) normal = normalized(normal);
  for (const double radius : {0.1, 0.4}) {
    const auto result = project_points(ball.positions, normals, 0, n, {radius, true});
    for (std::uint32_t i = 0; i < n; ++i) {
      REQUIRE(is_finite(result.positions[i]));
      REQUIRE(norm(result.positions[i] - ball.positions[i]) <= radius);
    }
  }
}

TEST_CASE("RadiiThatReachTensOfThousandsOfPointsAreRefused") {
  const PointCloud cloud = test::random_sphere(100000, 5).cloud;
  const auto n = static_cast<std::uint32_t>(cloud.size());
  const auto project = [&](double radius) {
    return project_points(cloud.positions, cloud.normals, 0, n,
                          {radius, true, nullptr, "clean.radius"});
  };
  CHECK_THROWS_WITH(project(1000.0), Catch::Contains("clean.radius"));
  CHECK_NOTHROW(project(0.05));
}

TEST_CASE("ProjectionScalesWithTheCloudAndWorksFarFromTheOrigin") {
  const PointCloud cloud = noisy_sphere(5000, 0.01, 12);
  const PointCloud one = projected(cloud, 0.2, 1);
  for (const int exponent : {-20, 20}) {
    PointCloud scaled = cloud;
    for (Vec3& p : scaled.positions) p = std::ldexp(1.0, exponent) * p;
    const PointCloud other = projected(scaled, std::ldexp(0.2, exponent), 1);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      REQUIRE(other.positions[i] == std::ldexp(1.0, exponent) * one.positions[i]);
      REQUIRE(other.normals[i] == one.normals[i]);
    }
  }
  // By whole cells: which points share a surface depends on where cells begin.
  const Vec3 far = NeighborGrid::cell_side(0.2) * Vec3{2.5e6, 2.1e7, 500.0};
  PointCloud moved = cloud;
  for (Vec3& p : moved.positions) p = p + far;
  const PointCloud other = projected(moved, 0.2, 1);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    REQUIRE(norm(other.positions[i] - far - one.positions[i]) < 1e-7);
}

}  // namespace orbweave
