// Cleaning that follows the noise: what is measured place by place, what follows from it, what
// stays untouched; small clusters and surfaceness.
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/cleaning/clusters.h"
#include "engine/cleaning/local_cleaning.h"
#include "engine/cleaning/surfaceness.h"
#include "engine/spacing/noise_places.h"
#include "engine/spacing/smoothing_levels.h"
#include "tests/engine/cleaning_parts.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

constexpr double kSpacing = 0.02;
constexpr double kCell = 12 * kSpacing;
constexpr double kSide = 1.0;

/// A sheet of 6 by 1 whose noise grows along x from nothing to 1.5 spacings, in the order of boxes.
PointCloud growing_noise(std::uint64_t seed = 5) {
  test::Random random(seed);
  PointCloud cloud;
  for (int i = 0; i < 300; ++i)
    for (int j = 0; j < 50; ++j) {
      const double x = kSpacing * (i + 0.3 * random.uniform()),
                   grown = std::max(0.0, x - 2.0) / 4.0;
      const double height = 1.5 * kSpacing * grown * 1.7 * (2.0 * random.uniform() - 1.0);
      cloud.positions.push_back({x, kSpacing * (j + 0.3 * random.uniform()), height});
      cloud.normals.push_back({0, 0, 1});
    }
  test::put_in_order(cloud);
  test::sort_by_boxes(cloud, kSide);
  return cloud;
}

NoisePlaceOptions place_options() { return {.cell = kCell, .reach = 2.0 * kCell}; }

std::vector<NoisePlace> places_of(const PointCloud& cloud) {
  return measure_noise_places(cloud.positions, 0, static_cast<std::uint32_t>(cloud.size()),
                              place_options());
}

WholeCloudNoise whole() { return {.radius = 3.75 * kSpacing, .is_thick = false}; }

SmoothingLevels levels_of(const PointCloud& cloud) { return {places_of(cloud), kCell, whole()}; }

using Row = std::array<double, 5>;
std::vector<Row> rows_of(const std::vector<NoisePlace>& places) {
  std::vector<Row> rows;
  for (const NoisePlace& p : places)
    rows.push_back({p.position.x, p.position.y, p.position.z, p.spacing, p.noise});
  return rows;
}

LeveledPoints all_of(const PointCloud& cloud, const std::vector<std::uint8_t>& levels) {
  return {cloud.positions, cloud.normals, 0, static_cast<std::uint32_t>(cloud.size()), levels};
}

/// Of a part, by the levels of the whole cloud.
LeveledPoints leveled(const test::CloudPart& part, const std::vector<std::uint8_t>& levels) {
  return {part.positions, part.normals, part.begin, part.end, levels};
}

}  // namespace

TEST_CASE("NoisePlacesOfPartsAreThoseOfTheWhole") {
  const PointCloud cloud = growing_noise();
  const auto compute = [](const test::CloudPart& part) {
    return rows_of(measure_noise_places(part.positions, part.begin, part.end, place_options()));
  };
  const auto whole_rows = test::in_one_part(cloud, compute);
  CHECK(whole_rows.size() > 50);
  CHECK(test::in_parts(cloud, kSide, noise_halo(place_options()), compute) == whole_rows);
  CHECK_FALSE(test::in_parts(cloud, kSide, 0.2 * noise_halo(place_options()), compute) ==
              whole_rows);
}

TEST_CASE("SmoothingReachesAsFarAsTheNoiseOfThePlaceAsks") {
  const SmoothingLevels levels = levels_of(growing_noise());
  REQUIRE(levels.radii().size() >= 4);
  const std::vector<Vec3> places = {{0.7, 0.5, 0}, {3.2, 0.5, 0}, {4.5, 0.5, 0}, {5.8, 0.5, 0}};
  const std::vector<std::uint8_t> at = levels.at(places);
  CHECK(levels.radii()[at[0]] == 0.0);
  CHECK(at[1] > 0);
  CHECK(at[2] >= at[1]);
  CHECK(at[3] > at[1]);
  // Twelve deviations of 1.2 spacings.
  CHECK(levels.radii()[at[3]] > 8 * kSpacing);
  CHECK(levels.radii()[at[3]] < 22 * kSpacing);
  CHECK(levels.untouched_share() > 0.25);
  CHECK(levels.untouched_share() < 0.6);
}

TEST_CASE("LevelsDoNotDependOnTheOrderOfPlaces") {
  const PointCloud cloud = growing_noise();
  std::vector<NoisePlace> places = places_of(cloud);
  const SmoothingLevels levels(places, kCell, whole());
  std::reverse(places.begin(), places.end());
  const SmoothingLevels other(places, kCell, whole());
  CHECK(levels.at(cloud.positions) == other.at(cloud.positions));
}

TEST_CASE("NoRadiusIsLargerThanTheMost") {
  WholeCloudNoise limited = whole();
  limited.most = limited.radius;
  const SmoothingLevels levels(places_of(growing_noise()), kCell, limited);
  CHECK(levels.radii().back() == limited.radius);
}

TEST_CASE("CleanCloudsHaveOneLevelAtWhichNothingMoves") {
  const PointCloud sheet = test::grid_sheet(60, 0.0).cloud;
  const SmoothingLevels levels(
      measure_noise_places(sheet.positions, 0, static_cast<std::uint32_t>(sheet.size()),
                           {.cell = 12.0, .reach = 24.0}),
      12.0, {.radius = 3.75});
  CHECK(levels.radii().size() == 1);
  CHECK(levels.untouched_share() == 1.0);
}

TEST_CASE("PlacesWithoutASurfaceAreSmoothedAsTheWholeCloudIs") {
  const PointCloud leaves = test::random_ball(4000, 3).cloud;
  const auto count = static_cast<std::uint32_t>(leaves.size());
  const double spacing = 0.08;
  const std::vector<NoisePlace> places = measure_noise_places(
      leaves.positions, 0, count, {.cell = 12 * spacing, .reach = 24 * spacing});
  for (const bool is_thick : {false, true}) {
    const SmoothingLevels levels(places, 12 * spacing, {.radius = 0.5, .is_thick = is_thick});
    const auto at = levels.at(std::vector<Vec3>{{0, 0, 0}});
    CHECK(levels.radii()[at[0]] == (is_thick ? 0.5 : 0.0));
  }
}

TEST_CASE("PointsAtLevelZeroStayToTheBit") {
  const PointCloud cloud = growing_noise();
  const SmoothingLevels levels = levels_of(cloud);
  const std::vector<std::uint8_t> at = levels.at(cloud.positions);
  const ProjectedPoints projected =
      project_locally(all_of(cloud, at), levels.radii(), {.radius = levels.radii().back()});
  std::size_t stayed = 0, moved = 0;
  double before = 0.0, after = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const bool stays =
        projected.positions[i] == cloud.positions[i] && projected.normals[i] == cloud.normals[i];
    if (at[i] == 0) CHECK(stays);
    stayed += at[i] == 0 ? 1 : 0;
    moved += projected.moved[i];
    before += std::abs(cloud.positions[i].z);
    after += std::abs(projected.positions[i].z);
  }
  CHECK(stayed > cloud.size() / 5);
  CHECK(moved > cloud.size() / 3);
  CHECK(after < 0.3 * before);
}

TEST_CASE("LocalProjectionOfOneLevelIsThatOfProjectPoints") {
  const PointCloud cloud = growing_noise();
  const std::vector<std::uint8_t> at(cloud.size(), 1);
  const std::vector<double> radii = {0.0, 0.1};
  const auto count = static_cast<std::uint32_t>(cloud.size());
  const ProjectionOptions options{.radius = 0.1};
  CHECK(project_locally(all_of(cloud, at), radii, options).positions ==
        project_points(cloud.positions, cloud.normals, 0, count, options).positions);
}

TEST_CASE("LocalCleaningOfPartsIsThatOfTheWhole", "[costly]") {
  const PointCloud cloud = growing_noise();
  const SmoothingLevels levels = levels_of(cloud);
  std::vector<double> spacings;
  for (const double radius : levels.radii()) spacings.push_back(0.25 * radius);
  const ProjectionOptions options{.radius = levels.radii().back()};
  const auto projected = [&](const test::CloudPart& part) {
    return project_locally(leveled(part, levels.at(part.positions)), levels.radii(), options)
        .positions;
  };
  CHECK(test::in_parts(cloud, kSide, local_projection_halo(levels.radii(), options), projected) ==
        test::in_one_part(cloud, projected));
  const auto thinned = [&](const test::CloudPart& part) {
    return thin_locally(leveled(part, levels.at(part.positions)), spacings, {.min_cosine = 0.5});
  };
  CHECK(test::in_parts(cloud, kSide, local_thinning_halo(spacings), thinned) ==
        test::in_one_part(cloud, thinned));
  CHECK_FALSE(test::in_parts(cloud, kSide, 0.05 * local_thinning_halo(spacings), thinned) ==
              test::in_one_part(cloud, thinned));
}

TEST_CASE("LocalThinningKeepsTheSpacingOfEachLevelAndAllOfLevelZero") {
  const PointCloud cloud = growing_noise();
  const SmoothingLevels levels = levels_of(cloud);
  const std::vector<std::uint8_t> at = levels.at(cloud.positions);
  std::vector<double> spacings;
  for (const double radius : levels.radii()) spacings.push_back(0.25 * radius);
  const std::vector<std::uint8_t> kept =
      thin_locally(all_of(cloud, at), spacings, {.min_cosine = 0.5});
  std::vector<std::uint32_t> rows;
  for (std::uint32_t i = 0; i < kept.size(); ++i) {
    if (at[i] == 0) CHECK(kept[i] == 1);
    if (kept[i] != 0) rows.push_back(i);
  }
  CHECK(rows.size() < cloud.size());
  const auto distance = [&](std::uint32_t i, std::uint32_t j) {
    return norm(cloud.positions[i] - cloud.positions[j]);
  };
  bool is_even = true, is_near = true;
  for (const std::uint32_t i : rows)
    for (const std::uint32_t j : rows)
      is_even = is_even && (i == j || at[std::max(i, j)] + at[std::min(i, j)] == 0 ||
                            distance(i, j) >= spacings[std::max(at[i], at[j])]);
  for (std::uint32_t i = 0; i < kept.size(); ++i) {
    if (kept[i] != 0) continue;
    is_near = is_near && std::any_of(rows.begin(), rows.end(), [&](std::uint32_t j) {
                return distance(i, j) < spacings[at[i]];
              });
  }
  CHECK(is_even);
  CHECK(is_near);
}

TEST_CASE("SmallClustersApartFromTheSurfaceAreFound") {
  PointCloud cloud = test::grid_sheet(30, 0.0).cloud;
  const std::size_t surface = cloud.size();
  const auto add = [&](Vec3 p) {
    cloud.positions.push_back(p);
    cloud.normals.push_back({0, 0, 1});
  };
  for (int i = 0; i < 5; ++i) add({10 + 0.5 * i, 10, 20});   // a drop
  for (int i = 0; i < 5; ++i) add({20 + 0.5 * i, 20, 1.5});  // close to the surface
  for (int i = 0; i < 14; ++i) add({4.0 * i, 5, 40});        // a wire
  for (int i = 0; i < 40; ++i) add({40 + 0.2 * i, 10, 60});  // many
  const ClusterOptions options{.points = 20, .gap = 5.0};
  const auto count = static_cast<std::uint32_t>(cloud.size());
  const auto found = find_clusters(cloud.positions, 0, count, options);
  for (std::size_t i = 0; i < found.size(); ++i)
    CHECK(found[i] == (i >= surface && i < surface + 5 ? 1 : 0));
  test::sort_by_boxes(cloud, 12.0);
  const auto compute = [&](const test::CloudPart& part) {
    return find_clusters(part.positions, part.begin, part.end, options);
  };
  CHECK(test::in_parts(cloud, 12.0, cluster_halo(options), compute) ==
        test::in_one_part(cloud, compute));
}

TEST_CASE("SurfacenessTellsSurfacesFromWiresAndLeaves") {
  PointCloud sheet = test::grid_sheet(40, 0.0).cloud;
  const auto count = static_cast<std::uint32_t>(sheet.size());
  const SurfacenessOptions options{.neighbors = 24, .max_radius = 10.0};
  const auto of_sheet = surfaceness_of(sheet.positions, 0, count, options);
  CHECK(of_sheet[count / 2 + 20] > 0.8F);
  for (const float one : of_sheet) CHECK(one > 0.15F);
  test::Random random(9);
  std::vector<Vec3> wire, leaves;
  for (int i = 0; i < 300; ++i) {
    wire.push_back({0.1 * i, 0.02 * random.uniform(), 0.02 * random.uniform()});
    leaves.push_back({random.uniform(), random.uniform(), random.uniform()});
  }
  const auto of_wire = surfaceness_of(wire, 0, 300, options);
  for (int i = 20; i < 280; ++i) CHECK(of_wire[i] < 0.05F);
  double sum = 0.0;
  for (const float one : surfaceness_of(leaves, 0, 300, options)) sum += one / 300.0;
  CHECK(sum < 0.3);
  CHECK(surfaceness_of(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}}, 0, 2, options) ==
        std::vector<float>{1.0F, 1.0F});
}

}  // namespace orbweave
