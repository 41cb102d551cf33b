#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "engine/cleaning/thinning.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

std::vector<std::uint8_t> thin(const PointCloud& cloud, const ThinningOptions& options) {
  return thin_points(cloud.positions, cloud.normals, 0, static_cast<std::uint32_t>(cloud.size()),
                     options);
}

bool stands_for(const PointCloud& cloud, std::size_t a, std::size_t b,
                const ThinningOptions& options) {
  return norm(cloud.positions[a] - cloud.positions[b]) < options.spacing &&
         dot(cloud.normals[a], cloud.normals[b]) >= options.min_cosine;
}

std::vector<std::size_t> indices_of(const std::vector<std::uint8_t>& kept) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (kept[i] != 0) indices.push_back(i);
  return indices;
}

}  // namespace

TEST_CASE("APointFartherThanCellsCanBeNumberedChangesNothingForTheOthers") {
  PointCloud cloud = test::noisy_torus(5000, 0.3, 4).cloud;
  const ThinningOptions options{0.05, 0.5};
  const auto last = static_cast<std::uint32_t>(cloud.size());
  const auto alone = thin_points(cloud.positions, cloud.normals, 0, last, options);
  cloud.positions.push_back({1e30, -1e30, 1e30});
  cloud.normals.push_back({0.0, 0.0, 1.0});
  CHECK(thin_points(cloud.positions, cloud.normals, 0, last, options) == alone);
}

TEST_CASE("KeptPointsAreASpacingApartAndStandForAllOthers", "[costly]") {
  for (const double factor : {0.5, 2.0, 6.0}) {
    const test::NamedCloud torus = test::noisy_torus(4000, 0.6, 7);
    const ThinningOptions options{factor * torus.ball_radius, 0.3};
    const auto flags = thin(torus.cloud, options);
    const auto kept = indices_of(flags);
    for (std::size_t i = 0; i < torus.cloud.size(); ++i) {
      const auto near = std::count_if(kept.begin(), kept.end(), [&](std::size_t k) {
        return k != i && stands_for(torus.cloud, i, k, options);
      });
      INFO("factor " << factor << ", point " << i << ", kept " << int{flags[i]});
      REQUIRE((near == 0) == (flags[i] != 0));
    }
  }
}

TEST_CASE("ThinningLeavesAsManyPointsAsItsSpacingAsksFor") {
  // Random sequential packing of discs of half the spacing covers 0.547 of the plane in the end;
  // points that are not infinitely dense leave some gaps too small for the next.
  const test::NamedCloud sphere = test::random_sphere(60000, 3);
  const double spacing = 0.05;
  const auto kept = indices_of(thin(sphere.cloud, {spacing, -1.0})).size();
  const double full = 0.547 * 4.0 / (spacing * spacing / 4.0);
  CHECK(static_cast<double>(kept) > 0.85 * full);
  CHECK(static_cast<double>(kept) < 1.02 * full);
}

TEST_CASE("SheetsThatFaceApartAreThinnedEachForItself") {
  const PointCloud sheets = test::grid_sheet(20, 0.1).cloud;
  const auto flags = thin(sheets, {2.5, 0.0});
  std::size_t above = 0, below = 0;
  for (std::size_t i = 0; i < sheets.size(); ++i)
    (sheets.normals[i].z > 0.0 ? above : below) += flags[i];
  const auto together = indices_of(thin(sheets, {2.5, -1.0})).size();
  CHECK(above > 40);
  CHECK(below > 40);
  CHECK(10 * together < 7 * (above + below));
  PointCloud unknown = sheets;
  unknown.normals.clear();
  CHECK(indices_of(thin(unknown, {2.5, 0.0})).size() == together);
}

TEST_CASE("ThinningDoesNotDependOnTheOrderOfPointsNorOnScale") {
  const PointCloud cloud = test::noisy_torus(4000, 0.4, 9).cloud;
  const ThinningOptions options{0.1, 0.5};
  const auto before = thin(cloud, options);
  PointCloud reversed = cloud;
  std::reverse(reversed.positions.begin(), reversed.positions.end());
  std::reverse(reversed.normals.begin(), reversed.normals.end());
  auto after = thin(reversed, options);
  std::reverse(after.begin(), after.end());
  CHECK(after == before);
  for (const int exponent : {-20, 20}) {
    PointCloud scaled = cloud;
    for (Vec3& p : scaled.positions) p = std::ldexp(1.0, exponent) * p;
    CHECK(thin(scaled, {std::ldexp(0.1, exponent), 0.5}) == before);
  }
}

TEST_CASE("TheLengthOfNormalsDoesNotMatter") {
  const PointCloud cloud = test::noisy_torus(3000, 0.5, 9).cloud;
  const auto n = static_cast<std::uint32_t>(cloud.size());
  const ThinningOptions options{0.12, 0.5};
  const MergedPoints before = merge_points(cloud.positions, cloud.normals, 0, n, options);
  PointCloud scaled = cloud;
  for (std::uint32_t i = 0; i < n; ++i)
    scaled.normals[i] = (i % 2 ? 0.125 : 8.0) * cloud.normals[i];
  CHECK(thin(scaled, options) == before.kept);
  CHECK(merge_points(scaled.positions, scaled.normals, 0, n, options).positions ==
        before.positions);
  // Without a normal a point stands for no other, and no other for it.
  scaled.normals.assign(n, Vec3{});
  CHECK(indices_of(thin(scaled, options)).size() == n);
}

TEST_CASE("ThinningWorksFarFromTheOriginAndWithStraysFarAway") {
  PointCloud cloud = test::noisy_torus(4000, 0.4, 9).cloud;
  const std::size_t here = indices_of(thin(cloud, {0.1, 0.5})).size();
  for (Vec3& p : cloud.positions) p = p + Vec3{500000.0, 4200000.0, 100.0};
  cloud.positions.push_back({1e12, -1e12, 1e12});
  cloud.normals.push_back({0, 0, 1});
  const auto flags = thin(cloud, {0.1, 0.5});
  CHECK(flags.back() == 1);
  CHECK(static_cast<double>(indices_of(flags).size()) ==
        Approx(static_cast<double>(here)).epsilon(0.05));
}

TEST_CASE("MergedPointsAreTheMeansOfWhatTheyStandFor") {
  const PointCloud cloud = test::noisy_torus(3000, 0.5, 11).cloud;
  const ThinningOptions options{0.12, 0.2};
  const auto n = static_cast<std::uint32_t>(cloud.size());
  const MergedPoints merged = merge_points(cloud.positions, cloud.normals, 0, n, options);
  CHECK(merged.kept == thin(cloud, options));
  const auto kept = indices_of(merged.kept);
  std::vector<Vec3> sums(n);
  std::vector<double> counts(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    std::size_t nearest = n;
    for (const std::size_t k : kept) {
      if (k != i && !stands_for(cloud, i, k, options)) continue;
      if (nearest == n || norm(cloud.positions[k] - cloud.positions[i]) <
                              norm(cloud.positions[nearest] - cloud.positions[i]))
        nearest = k;
    }
    sums[nearest] = sums[nearest] + cloud.positions[i];
    counts[nearest] += 1.0;
  }
  for (const std::size_t k : kept) {
    REQUIRE(norm(merged.positions[k] - sums[k] / counts[k]) < 1e-12);
    REQUIRE(norm(merged.normals[k]) == Approx(1.0));
  }
}

TEST_CASE("ThinningOfNothingIsNothing") {
  CHECK(thin({}, {1.0, 0.0}).empty());
  const MergedPoints merged = merge_points({}, {}, 0, 0, {1.0, 0.0});
  CHECK(merged.kept.empty());
  CHECK(merged.positions.empty());
}

}  // namespace orbweave
