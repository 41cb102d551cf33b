#include "engine/spacing/automatic_radii.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/geometry/point_tree.h"
#include "engine/spacing/site_search.h"
#include "engine/synthetic/synthetic_cloud.h"
#include "io/bounds.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/points/point_source.h"
#include "partition/count_grid.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

std::vector<Vec3> positions_of(Shape shape, std::uint64_t points, bool density_varying = false,
                               double noise = 0.0) {
  SyntheticOptions options;
  options.shape = shape;
  options.points = points;
  options.density_varying = density_varying;
  options.noise = noise;
  SyntheticCloud cloud(options);
  return read_all(cloud).positions;
}

RadiiChoice choice_for(const std::vector<Vec3>& positions, int levels, std::size_t batch = 4096,
                       std::size_t sites = 256, std::uint32_t points_per_site = 512) {
  CountGrid grid;
  const std::span<const Vec3> all = positions;
  for (std::size_t i = 0; i < all.size(); i += batch)
    grid.add(all.subspan(i, std::min(batch, all.size() - i)));
  const RootCube root = root_cube(grid.bounds());
  grid.settle(root.side);
  SpacingSampler sampler(root, grid, sites, points_per_site);
  for (std::size_t i = 0; i < all.size(); i += batch)
    sampler.add(all.subspan(i, std::min(batch, all.size() - i)));
  return sampler.choose(levels);
}

void shuffle(std::vector<Vec3>& points, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (std::size_t i = points.size(); i > 1; --i) std::swap(points[i - 1], points[random() % i]);
}

/// A smooth sheet over the square of side 1 that is a hundred times as dense at one side as at the
/// other, sampled by a jittered quasi-random sequence so that the spacing is even where the density
/// is.
PointCloud sheet_with_density_of_one_to_a_hundred(std::size_t points) {
  PointCloud cloud;
  cloud.schema.has_normals = true;
  for (std::size_t i = 0; i < points; ++i) {
    // Density 100^-x: its distribution's inverse.
    const double t = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(i), 1.0);
    const double x = -std::log(1.0 - 0.99 * t) / std::log(100.0);
    const double y = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(i), 1.0);
    cloud.positions.push_back({x, y, 0.05 * x * x + 0.03 * y * y});
    cloud.normals.push_back(normalized({-0.1 * x, -0.06 * y, 1.0}));
  }
  test::put_in_order(cloud);
  return cloud;
}

struct Quality {
  double used = 0.0;     ///< share of the points
  double covered = 0.0;  ///< area of the triangles' projections, of the square's
};

Quality quality_with(const PointCloud& cloud, const std::vector<double>& radii) {
  const auto result = ball_pivoting(cloud.positions, cloud.normals, {}, {radii, {}});
  std::vector<std::uint8_t> used(cloud.size(), 0);
  Quality quality;
  for (const Triangle& t : result.triangles) {
    for (const std::uint32_t v : t) used[v] = 1;
    const Vec3 a = cloud.positions[t[0]], b = cloud.positions[t[1]], c = cloud.positions[t[2]];
    quality.covered += 0.5 * std::abs(cross(b - a, c - a).z);
  }
  for (const std::uint8_t flag : used) quality.used += flag / static_cast<double>(cloud.size());
  return quality;
}

}  // namespace

TEST_CASE("ASiteIsSearchedAsATreeIs") {
  std::vector<Vec3> lattice;  // ties are everywhere
  for (int i = 0; i < 9 * 9 * 9; ++i)
    lattice.push_back({double(i % 9), double(i / 9 % 9), double(i / 81)});
  std::vector<Vec3> pair = {lattice[0], lattice[5]};
  for (const auto& points : {positions_of(Shape::kSphere, 3000), lattice, pair}) {
    const PointTree tree(points);
    const SiteSearch search(points);
    SiteSearch::Query query;
    for (const std::size_t count : {1u, 7u, 20u, 60u, 700u, 5000u}) {
      for (std::uint32_t point = 0; point < points.size(); point += 1 + point / 2) {
        std::vector<Neighbor> expected, found;
        tree.nearest(points[point], count, expected);
        query.nearest(search, point, count, found);
        REQUIRE(found == expected);
      }
    }
  }
}

TEST_CASE("PointsThatAreInfinitelyFarApartBySquaresAreFoundInOrder") {
  std::vector<Vec3> points;
  for (int i = 0; i < 100; ++i) points.push_back({0.25 * i, 1.0, 0.0});
  for (const double far : {1e200, -1e200, 1e300}) points.push_back({far, 0.0, 0.0});
  const SiteSearch search(points);
  SiteSearch::Query query;
  std::vector<Neighbor> found;
  for (const std::uint32_t point : {0U, 50U, 100U, 102U}) {
    query.nearest(search, point, points.size(), found);
    REQUIRE(found.size() == points.size());
    CHECK(found.front().index == point);
    CHECK(std::is_sorted(found.begin(), found.end(), kNearerFirst));
  }
}

TEST_CASE("DensitiesOfOneToAHundredAreClosedByRadiiFromTheDensity", "[costly]") {
  const PointCloud cloud = sheet_with_density_of_one_to_a_hundred(60000);
  const RadiiChoice choice = choice_for(cloud.positions, 0);
  const Quality closed = quality_with(cloud, choice.radii);
  INFO(choice.reason);
  CHECK(choice.radii.size() >= 4);
  CHECK(closed.used > 0.99);
  CHECK(closed.covered > 0.97);
  CHECK(choice.reason.find("levels lead") != std::string::npos);
  // One radius leaves the sparse side open.
  CHECK(quality_with(cloud, choice_for(cloud.positions, 1).radii).covered < 0.8);
}

TEST_CASE("UniformCloudsGetOneRadiusFromTheirDensity", "[costly]") {
  for (const Shape shape : all_shapes()) {
    for (const double noise : {0.0, 0.2}) {
      const std::vector<Vec3> points = positions_of(shape, 20000, false, noise);
      const RadiiChoice choice = choice_for(points, 0);
      INFO(name_of(shape) << ": " << choice.reason);
      CHECK(choice.radii == choice_for(points, 1).radii);
      CHECK(choice.reason.find("which one radius serves") != std::string::npos);
    }
  }
}

TEST_CASE("ScanLinesFarApartGetABallThatReachesFromOneToTheNext") {
  for (const double ratio : {5.0, 8.0, 25.0, 60.0}) {
    CAPTURE(ratio);
    const PointCloud cloud = test::sheet_of_lines(ratio, 40000).cloud;
    const RadiiChoice choice = choice_for(cloud.positions, 0);
    REQUIRE(choice.radii.size() == 1);
    const double gap = std::sqrt(ratio / 40000.0);
    CHECK(choice.radii.front() > 0.55 * gap);
    CHECK(choice.radii.front() < 0.75 * gap);
    CHECK_THAT(choice.reason, Catch::Contains("scan lines"));
    CHECK(static_cast<double>(choice.line_neighbors) > 1.3 * ratio);
    const Quality closed = quality_with(cloud, choice.radii);
    CHECK(closed.used > 0.999);
    CHECK(closed.covered > 0.95);
    // Sampled from parts of the cloud, in any order, the choice is about the same.
    std::vector<Vec3> shuffled = cloud.positions;
    shuffle(shuffled, 3);
    CHECK(choice_for(shuffled, 0).radii == choice.radii);
    const RadiiChoice sampled = choice_for(cloud.positions, 0, 4096, 16, 512);
    CHECK(sampled.radii.front() == Approx(choice.radii.front()).epsilon(0.05));
  }
}

TEST_CASE("NoiseOfTwoFifthsOfTheirPointDistanceHidesNoScanLines") {
  std::vector<Vec3> points = test::sheet_of_lines(15.0, 40000).cloud.positions;
  const double gap = std::sqrt(15.0 / 40000.0), noise = 1.2 * gap / 15.0;  // a bell's width is 1/3
  test::Random random(11);
  for (Vec3& p : points) p = p + noise * Vec3{random.bell(), random.bell(), random.bell()};
  const RadiiChoice choice = choice_for(points, 0);
  CHECK(choice.line_neighbors > 20);
  CHECK(choice.radii.front() > 0.5 * gap);
  CHECK(choice.radii.front() < 0.8 * gap);
}

TEST_CASE("AThreadAmongStraysAndAnEvenSheetAreNoScanLines") {
  std::vector<Vec3> thread;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> anywhere(0.0, 1.0);
  for (int i = 0; i < 9000; ++i) thread.push_back({i / 9000.0, 0.5, 0.5});
  for (int i = 0; i < 1000; ++i)
    thread.push_back({anywhere(random), anywhere(random), anywhere(random)});
  CHECK(choice_for(thread, 0).line_neighbors == 0);
  CHECK(choice_for(thread, 0).radii.front() < 0.01);
  // Strays as near to the thread as lines may be to each other.
  std::vector<Vec3> among_strays;
  for (int i = 0; i < 9000; ++i) among_strays.push_back({i / 9000.0, 0.0, 0.0});
  for (int i = 0; i < 2000; ++i)
    among_strays.push_back({anywhere(random), anywhere(random) * 0.01, anywhere(random) * 0.01});
  CHECK(choice_for(among_strays, 0).line_neighbors == 0);
  CHECK(choice_for(test::sheet_of_lines(2.0, 20000).cloud.positions, 0).line_neighbors == 0);
  CHECK(choice_for(positions_of(Shape::kBumpyTorus, 20000, false, 0.3), 0).line_neighbors == 0);
}

TEST_CASE("AFewStraysAddNoRadii") {
  std::vector<Vec3> points = positions_of(Shape::kTorus, 20000);
  for (int i = 0; i < 10; ++i) points.push_back({0.1 * i, 50.0 + 7.0 * i, 0.0});
  CHECK(choice_for(points, 0).radii.size() == 1);
}

TEST_CASE("LeavesAddNoRadiiAndASparseSheetOfAsManyPointsDoes") {
  const std::vector<Vec3> ground = positions_of(Shape::kTorus, 20000);
  constexpr int kSparse = 300;
  const double apart = 6.0 * choice_for(ground, 0).spacing;
  const double width = apart * std::cbrt(kSparse);
  std::mt19937_64 random(7);
  const auto fraction = [&] { return std::ldexp(static_cast<double>(random() >> 11), -53); };
  std::vector<Vec3> leaves = ground, sheet = ground;
  for (int i = 0; i < kSparse; ++i) {
    leaves.push_back(Vec3{5, 5, 5} + width * Vec3{fraction(), fraction(), fraction()});
    const int column = i % 20, row = i / 20;
    sheet.push_back(Vec3{5, 5, 5} +
                    apart * Vec3{column + 0.3 * fraction(), row + 0.3 * fraction(), 0.0});
  }
  CHECK(choice_for(leaves, 0).radii.size() == 1);
  CHECK(choice_for(sheet, 0).radii.size() >= 4);
}

TEST_CASE("AutomaticRadiiDoNotDependOnTheOrderOfPoints") {
  for (const bool varying : {false, true}) {
    std::vector<Vec3> points = positions_of(Shape::kBumpyTorus, 20000, varying, 0.2);
    // Few small sites, so that the choice of sites matters.
    const RadiiChoice before = choice_for(points, 3, 4096, 16, 64);
    std::reverse(points.begin(), points.end());
    CHECK(choice_for(points, 3, 1000, 16, 64).radii == before.radii);
    for (const std::uint64_t seed : {1u, 2u}) {
      shuffle(points, seed);
      const RadiiChoice after = choice_for(points, 3, 777, 16, 64);
      CHECK(after.radii == before.radii);
      CHECK(after.spacing == before.spacing);
      CHECK(after.reason == before.reason);
    }
  }
}

TEST_CASE("OfASiteWithMillionsOfPointsAPartIsMeasuredLikeTheWhole", "[costly]") {
  // One place, as a stray that is kept makes of a cloud: far more points than a tree is built of
  // within the time that a request to stop may take.
  constexpr std::size_t kPoints = SpacingSampler::kMostPointsOfSite + 300'000;
  std::vector<Vec3> points = positions_of(Shape::kBumpyTorus, kPoints);
  const Box box = bounds_of(points);
  const std::vector<SpacingSite> site{{box, box, points}};
  const SearchedSites searched(site);
  const RadiiChoice whole =
      choose_radii(SampledNeighbors(searched, neighbors_for_radii()), kPoints, 1);
  const auto choice_of = [&](const std::vector<Vec3>& in_order) {
    SpacingSampler sampler(std::vector<SpacingSite>{{box, box, in_order}}, kPoints);
    const StopToken stop;
    sampler.merge_duplicates(&stop);
    CHECK(stop.checks() > 20);
    CHECK(sampler.sites()[0].points.size() <= SpacingSampler::kMostPointsOfSite);
    CHECK(sampler.sites()[0].points.size() > SpacingSampler::kMostPointsOfSite / 4);
    return sampler.choose(1);
  };
  StopToken stop;
  stop.request();
  SpacingSampler stopped(std::vector<SpacingSite>{{box, box, points}}, kPoints);
  CHECK_THROWS_AS(stopped.merge_duplicates(&stop), Error);
  const RadiiChoice part = choice_of(points);
  REQUIRE(part.radii.size() == 1);
  CHECK(part.spacing == Approx(whole.spacing).epsilon(0.05));
  CHECK(part.radii[0] == Approx(whole.radii[0]).epsilon(0.05));
  shuffle(points, 3);
  CHECK(choice_of(points).radii == part.radii);
}

TEST_CASE("ASiteOfFewerPointsIsMeasuredWhole") {
  const std::vector<Vec3> points = positions_of(Shape::kBumpyTorus, 200'000);
  const Box box = bounds_of(points);
  SpacingSampler sampler(std::vector<SpacingSite>{{box, box, points}}, points.size());
  sampler.merge_duplicates();
  CHECK(sampler.sites()[0].points.size() == points.size());
  CHECK(sampler.sites()[0].core == box);
}

TEST_CASE("AutomaticRadiiScaleWithTheCloud") {
  const std::vector<Vec3> points = positions_of(Shape::kSphere, 30000, false, 0.1);
  const RadiiChoice one = choice_for(points, 3, 4096, 16, 64);
  for (const int exponent : {-20, 20}) {
    std::vector<Vec3> scaled = points;
    for (Vec3& p : scaled) p = std::ldexp(1.0, exponent) * p;
    const RadiiChoice other = choice_for(scaled, 3, 4096, 16, 64);
    REQUIRE(other.radii.size() == one.radii.size());
    for (std::size_t level = 0; level < one.radii.size(); ++level)
      CHECK(other.radii[level] == std::ldexp(one.radii[level], exponent));
  }
}

TEST_CASE("SampledRadiiAreThoseOfTheWholeCloud", "[costly]") {
  for (const Shape shape : {Shape::kSphere, Shape::kTorus, Shape::kPlane, Shape::kCube}) {
    const std::vector<Vec3> points = positions_of(shape, 40000);
    const RadiiChoice sampled = choice_for(points, 1, 4096, 32, 64);
    const RadiiChoice whole = choice_for(points, 1, 4096, 256, 512);
    REQUIRE(sampled.radii.size() == 1);
    INFO(name_of(shape) << ": " << sampled.reason);
    CHECK(sampled.spacing == Approx(whole.spacing).epsilon(0.03));
    CHECK(sampled.radii[0] == Approx(whole.radii[0]).epsilon(0.03));
  }
}

TEST_CASE("UniformCloudsGetABallALittleWiderThanTheirSpacing") {
  for (const Shape shape : all_shapes()) {
    SyntheticOptions options;
    options.shape = shape;
    options.points = 20000;
    const RadiiChoice choice = choice_for(positions_of(shape, options.points), 1);
    INFO(name_of(shape) << ": " << choice.reason);
    CHECK(choice.radii[0] > 1.1 * spacing(options));
    CHECK(choice.radii[0] < 1.45 * spacing(options));
  }
}

TEST_CASE("RadiiGrowByHalfFromLevelToLevel") {
  const RadiiChoice choice = choice_for(positions_of(Shape::kTorus, 5000), 4);
  REQUIRE(choice.radii.size() == 4);
  for (std::size_t level = 1; level < 4; ++level)
    CHECK(choice.radii[level] == Approx(1.5 * choice.radii[level - 1]));
}

TEST_CASE("VaryingDensityIsServedByLevelsAndTheReasonSaysSo") {
  const std::vector<Vec3> points = positions_of(Shape::kTorus, 20000, true);
  const RadiiChoice one = choice_for(points, 1), three = choice_for(points, 3);
  CHECK(three.radii.front() < one.radii.front());
  CHECK(three.radii.back() > one.radii.front());
  CHECK(three.reason.find("may need a larger radius") == std::string::npos);
}

TEST_CASE("ExactDuplicatesDoNotChangeAutomaticRadii") {
  std::vector<Vec3> points = positions_of(Shape::kTorus, 5000);
  const RadiiChoice before = choice_for(points, 2);
  const std::vector<Vec3> copy = points;
  for (int times = 0; times < 7; ++times) points.insert(points.end(), copy.begin(), copy.end());
  CHECK(choice_for(points, 2).radii == before.radii);
}

TEST_CASE("TinyCloudsGetRadiiAndPointsAllEqualGetNone") {
  CHECK(choice_for({{1, 2, 3}}, 1).radii.empty());
  CHECK_FALSE(choice_for({{1, 2, 3}}, 1).reason.empty());
  CHECK(choice_for(std::vector<Vec3>(1000, Vec3{4, 5, 6}), 3).radii.empty());
  CHECK(choice_for(std::vector<Vec3>(1000, Vec3{4, 5, 6}), 3, 100, 4, 16).radii.empty());
  const RadiiChoice two = choice_for({{0, 0, 0}, {0, 0, 2}}, 1);
  REQUIRE(two.radii.size() == 1);
  CHECK(two.radii[0] == Approx(2 * kRadiusPerSpacing));
  // The ball through an equilateral triangle fits.
  const RadiiChoice three = choice_for({{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}}, 1);
  REQUIRE(three.radii.size() == 1);
  CHECK(three.radii[0] > 1.0 / std::sqrt(3.0));
}

TEST_CASE("AFlyawayPointDoesNotSpoilAutomaticRadii") {
  std::vector<Vec3> points = positions_of(Shape::kTorus, 60000);
  const RadiiChoice before = choice_for(points, 1, 4096, 16, 64);
  points.push_back({5000.0, -3000.0, 1000.0});
  const RadiiChoice after = choice_for(points, 1, 4096, 16, 64);
  REQUIRE(after.radii.size() == 1);
  CHECK(after.radii[0] == Approx(before.radii[0]).epsilon(0.05));
}

TEST_CASE("AutomaticRadiiAreNearThoseChosenByHand", "[costly]") {
  struct Scan {
    const char* file;
    double by_hand;
  };
  for (const Scan& scan : {Scan{"stanford/bun_zipper.ply", 0.0015},
                           {"stanford/bun_zipper_res2.ply", 0.0028},
                           {"stanford/dragon_vrip_res2.ply", 0.0011},
                           {"stanford/dragon_vrip_res3.ply", 0.002},
                           {"stanford/dragon_vrip.ply", 0.00069},
                           {"points_normals/lion_takanawa_normals_rgb.ply", 0.012}}) {
    const auto path = test::data_path(scan.file);
    if (test::skipped_without(path)) return;
    const RadiiChoice choice = choice_for(read_all(*open_point_source(path)).positions, 1);
    INFO(scan.file << ": " << choice.reason);
    REQUIRE(choice.radii.size() == 1);
    CHECK(choice.radii[0] > 0.75 * scan.by_hand);
    CHECK(choice.radii[0] < 1.6 * scan.by_hand);
  }
}

}  // namespace orbweave
