#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/spacing/automatic_radii.h"
#include "engine/spacing/layer_thickness.h"
#include "engine/synthetic/synthetic_cloud.h"
#include "io/clouds/open_point_source.h"
#include "io/points/point_source.h"
#include "io/points/scan_pose.h"
#include "partition/count_grid.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

LayerThickness layers_of(const std::vector<Vec3>& positions) {
  CountGrid grid;
  grid.add(positions);
  const RootCube root = root_cube(grid.bounds());
  grid.settle(root.side);
  SpacingSampler sampler(root, grid);
  sampler.add(positions);
  return measure_layers(SearchedSites(sampler.sites()));
}

std::vector<Vec3> generated(Shape shape, double noise) {
  SyntheticOptions options;
  options.shape = shape;
  options.points = 30000;
  options.noise = noise;
  SyntheticCloud cloud(options);
  return read_all(cloud).positions;
}

bool does_nothing(const CleaningChoice& choice) {
  return choice.outlier_sigma == 0.0 && choice.smooth_radius == 0.0 &&
         choice.thin_to_spacing == 0.0;
}

}  // namespace

TEST_CASE("CleanCloudsNeedNoCleanUp") {
  for (const Shape shape : all_shapes()) {
    const LayerThickness layers = layers_of(generated(shape, 0.0));
    const CleaningChoice choice = choose_cleaning(layers);
    INFO(name_of(shape) << ": " << choice.noise);
    CHECK_FALSE(layers.is_thick());
    CHECK(does_nothing(choice));
    CHECK(choice.noise.find("; up to 9 %") != std::string::npos);
  }
}

TEST_CASE("TheNoiseIsToldInOneShortLine") {
  LayerThickness layers{.thickness = 0.0015, .spacing = 0.0432, .radius = 0.1, .measured = 100};
  CHECK(short_reason(layers) ==
        "noise 0.0015 RMS, 3 % of the point spacing (0.043); below 9 %: no cleaning needed");
  CHECK(short_reason(layers, 1.0) ==
        "noise 1.5 mm RMS, 3 % of the point spacing (43 mm); below 9 %: no cleaning needed");
  CHECK(short_noise(layers, 12.0 / 39.37) ==
        "noise 0.0015 ft RMS, 3 % of the point spacing (0.043 ft); below 9 %");
  layers.thickness = 0.00721;
  CHECK(short_noise(layers) == "noise 0.0072 RMS, 17 % of the point spacing (0.043); above 9 %");
  CHECK(short_reason(layers) ==
        short_noise(layers) + ": outliers dropped, 2 smoothing passes, thinned to 0.041");
  layers.thickness = 0.0897 * layers.spacing;
  CHECK(short_noise(layers).find(", 8.97 % of") != std::string::npos);
  layers.spacing = 432.0;
  CHECK(short_noise(layers).find("spacing (432)") != std::string::npos);
  CHECK(short_noise(layers, 1.0).find("spacing (432 m)") != std::string::npos);
  CHECK(short_noise(layers, 1000.0).find("spacing (432 km)") != std::string::npos);
  CHECK(short_reason({}) == "too few points to measure the noise: no cleaning");
}

TEST_CASE("NoiseIsMeasuredWhateverTheShape") {
  for (const Shape shape : {Shape::kSphere, Shape::kTorus, Shape::kPlane, Shape::kBumpyTorus}) {
    for (const double noise : {0.2, 0.4}) {
      SyntheticOptions options;
      options.shape = shape;
      options.points = 30000;
      const LayerThickness layers = layers_of(generated(shape, noise));
      const CleaningChoice choice = choose_cleaning(layers);
      INFO(name_of(shape) << ": " << choice.noise);
      CHECK(layers.thickness == Approx(noise * spacing(options)).epsilon(0.2));
      CHECK(layers.is_thick());
      CHECK(choice.smooth_radius > 3.0 * layers.spacing);
      CHECK(choice.thin_to_spacing < 0.5 * choice.smooth_radius);
      CHECK(choice.outlier_sigma > 0.0);
    }
  }
}

TEST_CASE("LayersMuchThickerThanTheirSpacingAreMeasuredInWideNeighborhoods") {
  test::Random random(5);
  std::vector<Vec3> points;
  for (int i = 0; i < 30000; ++i)
    points.push_back({random.uniform(), random.uniform(), 0.06 * random.uniform()});
  const LayerThickness layers = layers_of(points);
  // Evenly filled: the deviation is 1 / sqrt(12) of the thickness.
  CHECK(layers.thickness == Approx(0.06 / std::sqrt(12.0)).epsilon(0.25));
  CHECK(layers.radius > 0.06);
  CHECK(choose_cleaning(layers).smooth_radius > 0.12);
}

TEST_CASE("MeasuredLayersDoNotDependOnOrderAndScaleWithTheCloud") {
  std::vector<Vec3> points = generated(Shape::kTorus, 0.3);
  const LayerThickness one = layers_of(points);
  std::reverse(points.begin(), points.end());
  const LayerThickness other = layers_of(points);
  CHECK(other.thickness == one.thickness);
  CHECK(other.spacing == one.spacing);
  CHECK(choose_cleaning(other).noise == choose_cleaning(one).noise);
  for (const int exponent : {-20, 20}) {
    std::vector<Vec3> scaled = points;
    for (Vec3& p : scaled) p = std::ldexp(1.0, exponent) * p;
    CHECK(layers_of(scaled).thickness == std::ldexp(one.thickness, exponent));
  }
  for (Vec3& p : points) p = p + Vec3{500000.0, 4200000.0, 100.0};
  CHECK(layers_of(points).thickness == Approx(one.thickness).epsilon(0.05));
}

TEST_CASE("PointsThatFillASpaceAreMeasuredAtAFewPlacesWhateverTheirOrder") {
  test::Random random(6);
  std::vector<Vec3> points;
  for (int i = 0; i < 20000; ++i)
    points.push_back({random.uniform(), random.uniform(), random.uniform()});
  const LayerThickness one = layers_of(points);
  CHECK(one.measured >= 128);
  CHECK(one.measured <= 400);
  CHECK(one.is_thick());
  std::reverse(points.begin(), points.end());
  const LayerThickness other = layers_of(points);
  CHECK(other.measured == one.measured);
  CHECK(other.thickness == one.thickness);
  CHECK(choose_cleaning(other).noise == choose_cleaning(one).noise);
}

TEST_CASE("PlacesFollowTheNumberOfPoints") {
  // Three tenths of the points are leaves about a sheet, which must not end the measurement early.
  test::Random random(7);
  for (const std::size_t count : {20000u, 60000u}) {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < count; ++i)
      points.push_back({random.uniform(), random.uniform(),
                        i % 10 < 3 ? 0.2 + random.uniform() : 1e-4 * random.uniform()});
    const LayerThickness layers = layers_of(points);
    CHECK(static_cast<double>(layers.measured) ==
          Approx(static_cast<double>(count) / 16.0).epsilon(0.1));
  }
}

TEST_CASE("TinyCloudsAreLeftAlone") {
  for (const std::size_t n : {0u, 1u, 5u}) {
    const CleaningChoice choice = choose_cleaning(measure_layers(
        SearchedSites(std::vector{SpacingSite{{{0, 0, 0}, {9, 9, 9}},
                                              {{0, 0, 0}, {9, 9, 9}},
                                              std::vector<Vec3>(n, Vec3{1, 2, 3})}})));
    CHECK(does_nothing(choice));
    CHECK_FALSE(choice.noise.empty());
  }
}

TEST_CASE("VerticesOfCleanModelsNeedNoCleanUp") {
  for (const char* file :
       {"stanford/bun_zipper.ply", "stanford/bun_zipper_res2.ply", "stanford/bun_zipper_res3.ply",
        "stanford/bun_zipper_res4.ply", "stanford/dragon_vrip.ply", "stanford/dragon_vrip_res2.ply",
        "stanford/dragon_vrip_res3.ply", "stanford/dragon_vrip_res4.ply",
        "points_normals/kitten.xyz", "points_normals/oni.xyz"}) {
    const auto path = test::data_path(file);
    if (test::skipped_without(path)) return;
    const CleaningChoice choice =
        choose_cleaning(layers_of(read_all(*open_point_source(path)).positions));
    INFO(file << ": " << choice.noise);
    CHECK(does_nothing(choice));
  }
}

TEST_CASE("TheTenBunnyScansAreSmoothedWithinAMillimetreAndAHalf") {
  const auto conf = test::data_path("stanford/bunny_scans/bun.conf");
  if (test::skipped_without(conf)) return;
  std::vector<Vec3> points;
  for (const ScanPose& pose : read_stanford_poses(conf)) {
    const auto source = open_point_source(conf.parent_path() / pose.file);
    for (const Vec3& p : read_all(*source).positions) points.push_back(pose.motion.point(p));
  }
  const CleaningChoice choice = choose_cleaning(layers_of(points));
  INFO(choice.noise);
  // A search by hand ended at 0.0016 and 0.0004.
  CHECK(choice.smooth_radius == Approx(0.0016).epsilon(0.15));
  CHECK(choice.thin_to_spacing == Approx(0.0004).epsilon(0.15));
}

TEST_CASE("TheLionIsThick") {
  const auto path = test::data_path("points_normals/lion_takanawa_normals_rgb.ply");
  if (test::skipped_without(path)) return;
  const LayerThickness layers = layers_of(read_all(*open_point_source(path)).positions);
  CHECK(layers.is_thick());
}

}  // namespace orbweave
