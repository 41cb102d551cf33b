// Every stage of the clean-up: a part with its halo computes what the whole cloud computes, to the
// last bit, and with much less around it does not.
#include <catch2/catch.hpp>

#include "engine/cleaning/outliers.h"
#include "engine/cleaning/projection.h"
#include "engine/cleaning/thinning.h"
#include "engine/normals/estimate_normals.h"
#include "tests/engine/cleaning_parts.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

using test::CloudPart;

constexpr double kSide = 0.3;

/// Torus with noise, a few strays and a patch that is four times as dense.
PointCloud scan_like(std::uint64_t seed) {
  PointCloud cloud = test::noisy_torus(12000, 0.5, seed).cloud;
  test::Random random(seed);
  const PointCloud before = cloud;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const Vec3 step = 0.02 * random.direction();
    if (before.positions[i].x < 0.4 && i % 40 != 0) continue;
    for (const double factor : {0.3, 0.6, before.positions[i].x < 0.4 ? 6.0 : 0.9}) {
      cloud.append(before, i);
      cloud.positions.back() = cloud.positions.back() + factor * step;
    }
  }
  test::put_in_order(cloud);
  test::sort_by_boxes(cloud, kSide);
  return cloud;
}

/// Compares all parts with the whole; also that a tenth of the halo is too little.
template <class Compute>
void check_locality(double halo, const Compute& compute) {
  for (const std::uint64_t seed : {3u, 4u}) {
    const PointCloud cloud = scan_like(seed);
    const auto whole = test::in_one_part(cloud, compute);
    REQUIRE(whole.size() == cloud.size());
    CHECK(test::in_parts(cloud, kSide, halo, compute) == whole);
    CHECK_FALSE(test::in_parts(cloud, kSide, 0.1 * halo, compute) == whole);
  }
}

}  // namespace

TEST_CASE("OutliersOfPartsAreThoseOfTheWhole", "[costly]") {
  const OutlierOptions options{.sigma = 2.0, .neighbors = 12, .max_radius = 0.12};
  check_locality(outlier_halo(options), [&](const CloudPart& part) {
    return find_outliers(part.positions, part.begin, part.end, options);
  });
}

TEST_CASE("PointsExactlyAtTheRadiusDoNotDependOnTheCut") {
  // Rows whose distances and halos round differently.
  for (const double step : {0.1, 0.3, 0.7}) {
    for (const Vec3 corner : {Vec3{}, Vec3{-1.3, -0.7, 0.1}, Vec3{500000.1, 4200000.3, 0.0}}) {
      PointCloud grid;
      for (int k = 0; k < 1600; ++k) {
        const int i = k / 40, j = k % 40;
        const double height = 0.1 * step * ((i + 2 * j) % 3);
        grid.positions.push_back(Vec3{i * step, j * step, height} + corner);
        grid.normals.push_back({0, 0, 1});
      }
      test::sort_by_boxes(grid, 7.0 * step);
      const double radius = 3.0 * step;
      const auto normals = [&](const CloudPart& part) {
        return estimate_normals(part.positions, part.begin, part.end, {60, radius}).normals;
      };
      const auto projected = [&](const CloudPart& part) {
        return project_points(part.positions, part.normals, part.begin, part.end, {radius, true})
            .positions;
      };
      CHECK(test::in_parts(grid, 7.0 * step, radius, normals) == test::in_one_part(grid, normals));
      CHECK(test::in_parts(grid, 7.0 * step, projection_halo({radius, true}), projected) ==
            test::in_one_part(grid, projected));
    }
  }
}

TEST_CASE("NormalsThatPointsOfACubeShareAreThoseOfTheWhole", "[costly]") {
  const NormalEstimateOptions options{.neighbors = 24, .max_radius = 0.15, .shared_side = 0.05};
  check_locality(normal_halo(options), [&](const CloudPart& part) {
    return estimate_normals(part.positions, part.begin, part.end, options).normals;
  });
}

TEST_CASE("ThinnedPartsAreTheThinnedWhole", "[costly]") {
  for (const double min_cosine : {0.5, -1.0}) {
    const ThinningOptions options{0.06, min_cosine};
    check_locality(thinning_halo(options), [&](const CloudPart& part) {
      return thin_points(part.positions, part.normals, part.begin, part.end, options);
    });
  }
}

TEST_CASE("MergedPartsAreTheMergedWhole", "[costly]") {
  const ThinningOptions options{0.04, 0.5};
  check_locality(merging_halo(options), [&](const CloudPart& part) {
    const MergedPoints merged =
        merge_points(part.positions, part.normals, part.begin, part.end, options);
    std::vector<std::tuple<int, Vec3, Vec3>> rows;
    for (std::size_t i = 0; i < merged.kept.size(); ++i) {
      if (merged.kept[i] == 0)
        rows.push_back({0, {}, {}});
      else
        rows.push_back({1, merged.positions[i], merged.normals[i]});
    }
    return rows;
  });
}

TEST_CASE("ProjectedPartsAreTheProjectedWhole", "[costly]") {
  for (const bool oriented : {true, false}) {
    const ProjectionOptions options{0.1, oriented};
    check_locality(projection_halo(options), [&](const CloudPart& part) {
      const ProjectedPoints projected =
          project_points(part.positions, part.normals, part.begin, part.end, options);
      std::vector<std::tuple<int, Vec3, Vec3>> rows;
      for (std::size_t i = 0; i < projected.moved.size(); ++i)
        rows.push_back({projected.moved[i], projected.positions[i], projected.normals[i]});
      return rows;
    });
  }
}

}  // namespace orbweave
