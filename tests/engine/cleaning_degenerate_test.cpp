// Clouds that are hardly any, through every stage of the raw points.
#include <catch2/catch.hpp>
#include <numeric>

#include "engine/cleaning/outliers.h"
#include "engine/cleaning/projection.h"
#include "engine/cleaning/thinning.h"
#include "engine/normals/estimate_normals.h"
#include "engine/normals/orientation.h"
#include "engine/spacing/layer_thickness.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

struct Placing {
  double scale;
  Vec3 offset;
};
const Placing kPlacings[] = {{1.0, {}}, {1e-6, {}}, {1e6, {}}, {1.0, {500000.0, 4200000.0, 100.0}}};

PointCloud placed(const std::vector<Vec3>& positions, const Placing& placing) {
  PointCloud cloud;
  for (const Vec3& p : positions) cloud.positions.push_back(placing.scale * p + placing.offset);
  test::put_in_order(cloud);
  return cloud;
}

std::vector<Vec3> row_of_points(int count) {
  std::vector<Vec3> row;
  for (int i = 0; i < count; ++i) row.push_back({1.0 * i, 2.0 * i, 2.0 * i});
  return row;
}

std::uint32_t size_of(const PointCloud& cloud) { return static_cast<std::uint32_t>(cloud.size()); }

}  // namespace

TEST_CASE("PointsOnALineHaveNoNormalAndStayWhereTheyAre") {
  for (const Placing& placing : kPlacings) {
    const PointCloud cloud = placed(row_of_points(100), placing);
    const std::uint32_t n = size_of(cloud);
    const double radius = 30.0 * placing.scale;
    const auto found = estimate_normals(cloud.positions, 0, n, {16, radius});
    CHECK(found.normals == std::vector<Vec3>(n));
    const std::vector<Vec3> up(n, Vec3{0, 0, 1});
    const auto moved = project_points(cloud.positions, up, 0, n, {radius, true});
    CHECK(moved.positions == cloud.positions);
    CHECK(moved.normals == up);
    CHECK(std::accumulate(moved.moved.begin(), moved.moved.end(), 0) == 0);
  }
}

TEST_CASE("ThreePointsAreOutliersAndOtherwiseLeftAlone") {
  for (const Placing& placing : kPlacings) {
    const PointCloud cloud = placed({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, placing);
    const double radius = 4.0 * placing.scale;
    CHECK(find_outliers(cloud.positions, 0, 3, {.max_radius = radius}) ==
          std::vector<std::uint8_t>(3, 1));
    CHECK(estimate_normals(cloud.positions, 0, 3, {16, radius}).normals == std::vector<Vec3>(3));
    const std::vector<Vec3> up(3, Vec3{0, 0, 1});
    const auto moved = project_points(cloud.positions, up, 0, 3, {radius, true});
    for (int i = 0; i < 3; ++i) {
      CHECK(norm(moved.positions[i] - cloud.positions[i]) < 1e-9 * placing.scale);
      CHECK(norm(moved.normals[i] - up[i]) < 1e-9);
    }
    CHECK(thin_points(cloud.positions, up, 0, 3, {0.5 * placing.scale, 0.5}) ==
          std::vector<std::uint8_t>(3, 1));
    const auto merged = merge_points(cloud.positions, up, 0, 3, {radius, 0.5});
    CHECK(std::accumulate(merged.kept.begin(), merged.kept.end(), 0) == 1);
  }
}

TEST_CASE("PointsWithoutNormalsAreNoPatchesAndChooseNoCleanUp") {
  for (const std::size_t count : {0u, 1u, 2u, 3u, 40u}) {
    const std::vector<Vec3> positions = row_of_points(static_cast<int>(count));
    std::vector<std::uint64_t> global(count);
    std::iota(global.begin(), global.end(), 7);
    const std::vector<Vec3> none(count);
    const auto patches =
        orient_patches(positions, none, global, 0, static_cast<std::uint32_t>(count),
                       {.cell = 8.0, .max_radius = 20.0});
    CHECK(patches.patch_of == global);
    CHECK(patches.sums.empty());
    CHECK(patches.votes.empty());
    const Box all{{-1e9, -1e9, -1e9}, {1e9, 1e9, 1e9}};
    CHECK(measure_layers(SearchedSites(std::vector{SpacingSite{all, all, positions}})).measured ==
          0);
  }
}

TEST_CASE("PointsAtOnePlaceAreProjectedToOnePlace") {
  // Five times the points of a slightly bent sheet.
  const PointCloud sheet = test::random_sphere(600, 3).cloud;
  std::vector<Vec3> positions, normals;
  for (std::size_t i = 0; i < 5 * sheet.size(); ++i) {
    positions.push_back(sheet.positions[i / 5]);
    normals.push_back(sheet.normals[i / 5]);
  }
  const auto n = static_cast<std::uint32_t>(positions.size());
  const auto moved = project_points(positions, normals, 0, n, {0.5, true});
  for (std::uint32_t i = 0; i < n; ++i) {
    REQUIRE(moved.moved[i] == 1);
    REQUIRE(is_finite(moved.positions[i]));
    REQUIRE(moved.positions[i] == moved.positions[i / 5 * 5]);
  }
}

}  // namespace orbweave
