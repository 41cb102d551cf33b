#include "engine/synthetic/synthetic_cloud.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include <catch2/catch.hpp>

#include "engine/geometry/point_tree.h"
#include "engine/synthetic/portable_math.h"
#include "io/error.h"
#include "tests/engine/analytic_shapes.h"

namespace orbweave {
namespace {

using test::fingerprint;
using test::implicit;
using test::implicit_gradient;

PointCloud cloud_of(const SyntheticOptions& options, std::size_t batch_points = 4096) {
  SyntheticCloud source(options);
  PointCloud batch, all;
  all.schema = source.schema();
  while (source.read(batch, batch_points)) all.append(batch);
  return all;
}

SyntheticOptions shape_options(Shape shape, std::uint64_t points, bool density_varying = false) {
  SyntheticOptions options;
  options.shape = shape;
  options.points = points;
  options.density_varying = density_varying;
  return options;
}

struct Spread {
  double nearest_min = std::numeric_limits<double>::infinity();
  double nearest_max = 0.0;
  double gap_max = 0.0;  ///< from any point of the surface to the cloud
};

Spread spread(const SyntheticOptions& options) {
  const PointCloud cloud = cloud_of(options);
  const PointTree tree(cloud.positions);
  Spread result;
  std::vector<Neighbor> found;
  for (const Vec3& p : cloud.positions) {
    tree.nearest(p, 2, found);
    result.nearest_min = std::min(result.nearest_min, std::sqrt(found[1].squared_distance));
    result.nearest_max = std::max(result.nearest_max, std::sqrt(found[1].squared_distance));
  }
  SyntheticOptions dense = options;
  dense.points = 37 * options.points;
  for (Vec3 p : cloud_of(dense).positions) {
    // The wall's gap follows the number of points.
    if (options.shape == Shape::kDoubleWall && p.z > 0.0) p.z = 3.0 * spacing(options);
    result.gap_max = std::max(result.gap_max, std::sqrt(tree.nearest(p).squared_distance));
  }
  return result;
}

}  // namespace

TEST_CASE("SineAndCosineAgreeWithTheLibraryToTheLastBits") {
  for (int i = -2000; i <= 2000; ++i) {
    const double turns = i / 256.0;  // whole turns come off exactly
    const portable::SineCosine own = portable::sine_cosine(turns);
    const double angle = 2.0 * portable::kPi * (turns - std::floor(turns));
    CHECK(std::abs(own.sine - std::sin(angle)) < 1e-15);
    CHECK(std::abs(own.cosine - std::cos(angle)) < 1e-15);
  }
  for (double x = 1.0; x <= 64.0; x += 0.37)
    CHECK(std::abs(portable::cube_root(x) - std::cbrt(x)) < 4e-15);
}

TEST_CASE("EveryShapeGivesExactlyTheRequestedNumberOfPoints") {
  for (const Shape shape : all_shapes())
    for (const bool varying : {false, true})
      for (const std::uint64_t points : {1u, 2u, 3u, 7u, 8u, 20u, 97u, 1000u, 10007u}) {
        const SyntheticOptions options = shape_options(shape, points, varying);
        INFO(name_of(shape) << " " << points << (varying ? " varying" : ""));
        const PointCloud cloud = cloud_of(options);
        CHECK(cloud.size() == points);
        CHECK(cloud.normals.size() == points);
        CHECK(std::all_of(cloud.positions.begin(), cloud.positions.end(), is_finite));
      }
}

TEST_CASE("PointsLieOnTheSurfaceAndNormalsAreItsGradient") {
  for (const Shape shape : all_shapes())
    for (const bool varying : {false, true}) {
      const SyntheticOptions options = shape_options(shape, 3000, varying);
      const double gap = 3.0 * spacing(options);
      const PointCloud cloud = cloud_of(options);
      INFO(name_of(shape) << (varying ? " varying" : ""));
      double off_surface = 0.0, off_unit = 0.0, off_gradient = 0.0;
      for (std::size_t i = 0; i < cloud.size(); ++i) {
        const Vec3 p = cloud.positions[i], n = cloud.normals[i];
        off_surface = std::max(off_surface, std::abs(implicit(shape, gap, p)));
        off_unit = std::max(off_unit, std::abs(norm(n) - 1.0));
        // On the cube's edges the gradient's direction is the mean of the faces' too.
        off_gradient = std::max(off_gradient, norm(n - implicit_gradient(shape, gap, p)));
      }
      CHECK(off_surface < 1e-14);
      CHECK(off_unit < 1e-15);
      CHECK(off_gradient < 1e-8);
    }
}

TEST_CASE("SyntheticCloudDoesNotDependOnTheBatchSize") {
  for (const Shape shape : all_shapes()) {
    SyntheticOptions options = shape_options(shape, 5000, true);
    options.noise = 0.3;
    const PointCloud whole = cloud_of(options, 5000);
    for (const std::size_t batch : {1u, 17u, 999u, 100000u}) {
      const PointCloud pieces = cloud_of(options, batch);
      CHECK(pieces.positions == whole.positions);
      CHECK(pieces.normals == whole.normals);
    }
  }
}

TEST_CASE("UniformCloudsHaveNoGapsAndNoClosePairs", "[costly]") {
  for (const Shape shape : all_shapes())
    for (const std::uint64_t points : {1000u, 10000u}) {
      const SyntheticOptions options = shape_options(shape, points);
      const Spread s = spread(options);
      INFO(name_of(shape) << " " << points << ": " << s.nearest_min / spacing(options) << " to "
                          << s.nearest_max / spacing(options) << ", gap "
                          << s.gap_max / spacing(options));
      // Bumps stretch and squeeze their rows a little; the plate's rows end at its rims.
      const bool squeezes = shape == Shape::kBumpyTorus || shape == Shape::kGenusThree;
      CHECK(s.nearest_min > (squeezes ? 0.65 : 0.85) * spacing(options));
      CHECK(s.nearest_max < 1.2 * spacing(options));
      CHECK(s.gap_max < 0.9 * spacing(options));
    }
}

TEST_CASE("VaryingDensityRunsFromOneToSixteenAndStaysLocallyUniform") {
  for (const Shape shape : all_shapes()) {
    const SyntheticOptions options = shape_options(shape, 20000, true);
    const PointCloud cloud = cloud_of(options);
    const PointTree tree(cloud.positions);
    std::vector<double> first, fourth_by_first;
    std::vector<Neighbor> found;
    for (const Vec3& p : cloud.positions) {
      tree.nearest(p, 5, found);
      first.push_back(std::sqrt(found[1].squared_distance));
      fourth_by_first.push_back(std::sqrt(found[4].squared_distance / found[1].squared_distance));
    }
    std::sort(first.begin(), first.end());
    std::sort(fourth_by_first.begin(), fourth_by_first.end());
    INFO(name_of(shape) << ": " << first.back() / first.front() << ", "
                        << fourth_by_first[fourth_by_first.size() * 99 / 100]);
    CHECK(first.back() / first.front() > 3.2);
    CHECK(first.back() / first.front() < 6.5);
    CHECK(fourth_by_first[fourth_by_first.size() * 99 / 100] < 1.8);
  }
}

TEST_CASE("NoiseHasTheStatedDeviationAlongEveryAxis") {
  SyntheticOptions options = shape_options(Shape::kTorus, 200000);
  const PointCloud clean = cloud_of(options);
  options.noise = 0.3;
  const PointCloud noisy = cloud_of(options);
  Vec3 mean, square;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const Vec3 d = (noisy.positions[i] - clean.positions[i]) / spacing(options);
    mean = mean + d;
    for (int axis = 0; axis < 3; ++axis) square[axis] += d[axis] * d[axis];
  }
  const auto n = static_cast<double>(clean.size());
  for (int axis = 0; axis < 3; ++axis) {
    CHECK(std::abs(mean[axis] / n) < 5 * 0.3 / std::sqrt(n));
    CHECK(std::sqrt(square[axis] / n) == Approx(0.3).epsilon(0.01));
  }
  CHECK(noisy.normals == clean.normals);
  options.seed = 2;
  CHECK(cloud_of(options).positions != noisy.positions);
}

TEST_CASE("Float32CloudsHoldValuesThatFloatsHold") {
  SyntheticOptions options = shape_options(Shape::kSphere, 500);
  options.precision = ScalarType::kFloat32;
  const PointCloud cloud = cloud_of(options);
  CHECK(cloud.schema.position_type == ScalarType::kFloat32);
  std::size_t not_floats = 0;
  for (const Vec3& p : cloud.positions)
    for (int axis = 0; axis < 3; ++axis)
      not_floats += (std::bit_cast<std::uint64_t>(p[axis]) & ((1u << 29) - 1)) != 0;
  CHECK(not_floats == 0);
}

TEST_CASE("SyntheticCloudsAreTheSameBitsOnEveryMachine") {
  const std::map<Shape, std::uint64_t> expected = {
      {Shape::kSphere, 0xd0a6397a69c288f6},        {Shape::kTorus, 0xbeb909374f1b6a65},
      {Shape::kBumpyTorus, 0x5dec2c35282eb8ea},    {Shape::kPlane, 0xd74e873c3bcb7ef3},
      {Shape::kDoubleWall, 0x32fb10e954d53689},    {Shape::kCube, 0x2ab1be2ad01b7d48},
      {Shape::kTwoComponents, 0x0469709bc3238aac}, {Shape::kGenusThree, 0xd9cc5c1b881e74f4}};
  for (const Shape shape : all_shapes()) {
    SyntheticOptions options = shape_options(shape, 500, true);
    options.noise = 0.1;
    PointCloud both = cloud_of(options);
    options.density_varying = false;
    both.append(cloud_of(options));
    INFO(name_of(shape) << std::hex << " 0x" << fingerprint(both));
    CHECK(fingerprint(both) == expected.at(shape));
  }
}

TEST_CASE("NominalSpacingIsTheRootOfAreaPerPoint", "[costly]") {
  for (const Shape shape : all_shapes()) {
    const SyntheticOptions options = shape_options(shape, 1000);
    const TriangleMesh mesh = truth_mesh(options, 300);
    double area = 0.0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 a = mesh.vertices.positions[t[0]];
      area +=
          0.5 * norm(cross(mesh.vertices.positions[t[1]] - a, mesh.vertices.positions[t[2]] - a));
    }
    INFO(name_of(shape));
    CHECK(area == Approx(surface_area(shape)).epsilon(1e-3));
    CHECK(spacing(options) == Approx(std::sqrt(area / 1000)).epsilon(1e-3));
  }
}

TEST_CASE("TruthMeshesAreOrientedLikeTheNormalsAndClosedWhereTheShapeIs") {
  for (const Shape shape : all_shapes()) {
    const TriangleMesh mesh = truth_mesh(shape_options(shape, 1000), 40);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
    std::size_t facing_away = 0, open = 0, reused = 0;
    for (const Triangle& t : mesh.triangles) {
      const Vec3 a = mesh.vertices.positions[t[0]];
      const Vec3 normal =
          cross(mesh.vertices.positions[t[1]] - a, mesh.vertices.positions[t[2]] - a);
      for (int k = 0; k < 3; ++k) {
        facing_away += !(dot(normal, mesh.vertices.normals[t[k]]) > 0.0);
        ++directed[{t[k], t[(k + 1) % 3]}];
      }
    }
    for (const auto& [edge, count] : directed) {
      reused += count > 1;
      open += directed.count({edge.second, edge.first}) == 0;
    }
    INFO(name_of(shape));
    const std::size_t sheets = shape == Shape::kPlane ? 1 : shape == Shape::kDoubleWall ? 2 : 0;
    CHECK(facing_away == 0);
    CHECK(reused == 0);
    CHECK(open == 4 * 40 * sheets);
  }
}

TEST_CASE("ShapeNamesRoundTripAndWrongOptionsAreUsageErrors") {
  for (const Shape shape : all_shapes()) CHECK(shape_named(name_of(shape)) == shape);
  CHECK_FALSE(shape_named("teapot").has_value());
  SyntheticOptions options;
  options.points = 0;
  CHECK_THROWS_AS(SyntheticCloud(options), Error);
  options.points = 10;
  options.noise = -1.0;
  CHECK_THROWS_AS(SyntheticCloud(options), Error);
  options.noise = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(SyntheticCloud(options), Error);
}

}  // namespace orbweave
