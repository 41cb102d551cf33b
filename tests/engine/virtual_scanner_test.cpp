#include "engine/synthetic/virtual_scanner.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "engine/geometry/point_tree.h"
#include "engine/synthetic/portable_math.h"
#include "io/error.h"
#include "tests/engine/analytic_shapes.h"

namespace orbweave {
namespace {

using test::implicit;
using test::implicit_gradient;

VirtualScannerOptions scans_of(Shape shape, std::uint64_t points, int scans) {
  VirtualScannerOptions options;
  options.surface.shape = shape;
  options.surface.points = points;
  options.scans = scans;
  return options;
}

PointCloud all_of(PointSource& source, std::size_t batch_points = 4096) {
  PointCloud batch, all;
  all.schema = source.schema();
  while (source.read(batch, batch_points)) all.append(batch);
  return all;
}

double gap_of(const VirtualScannerOptions& options) { return 3.0 * spacing(options.surface); }

/// Whether the way from p, on the surface, to a scanner far away in `direction` is free.
bool is_free(const VirtualScannerOptions& options, Vec3 p, Vec3 direction) {
  constexpr double kStep = 0.01;
  for (double way = 2 * kStep; way < 3.0; way += kStep)
    if (implicit(options.surface.shape, gap_of(options), p + way * direction) < -2e-3) return false;
  return true;
}

double cosine_of(const VirtualScannerOptions& options, Vec3 p, Vec3 direction) {
  return dot(implicit_gradient(options.surface.shape, gap_of(options), p), direction);
}

const double kGrazing = std::cos(80.0 * portable::kPi / 180.0);

}  // namespace

TEST_CASE("ScannedPointsLieOnTheSurfaceInWorldCoordinates", "[costly]") {
  for (const Shape shape : all_shapes())
    for (const int scans : {1, 6, 14}) {
      const VirtualScannerOptions options = scans_of(shape, 20000, scans);
      const VirtualScanner scanner(options);
      const PointCloud cloud = all_of(*scanner.all());
      INFO(name_of(shape) << " " << scans);
      double off_surface = 0.0;
      for (const Vec3& p : cloud.positions)
        off_surface = std::max(off_surface, std::abs(implicit(shape, gap_of(options), p)));
      CHECK(off_surface < 1e-13);
      CHECK(cloud.normals.empty());
      CHECK(cloud.size() == scanner.points());
      CHECK(static_cast<double>(cloud.size()) == Approx(20000).epsilon(0.02));
    }
}

TEST_CASE("EveryPointFacesItsScannerAndNothingIsInBetween", "[costly]") {
  for (const Shape shape : {Shape::kSphere, Shape::kTorus, Shape::kBumpyTorus, Shape::kCube}) {
    const VirtualScannerOptions options = scans_of(shape, 5000, 9);
    const VirtualScanner scanner(options);
    const auto source = scanner.all();
    std::size_t hidden = 0, grazing = 0, nearly_grazing = 0;
    for (PointCloud batch; source->read(batch, 1000);) {
      const Vec3 direction = source->scanner()->vector;
      CHECK(source->scanner()->is_direction);
      for (const Vec3& p : batch.positions) {
        const double cosine = cosine_of(options, p, direction);
        grazing += cosine < kGrazing - 1e-6;
        nearly_grazing += cosine < kGrazing + 0.1;
        hidden += !is_free(options, p, direction);
      }
    }
    INFO(name_of(shape));
    CHECK(hidden == 0);
    CHECK(grazing == 0);
    if (shape != Shape::kCube) CHECK(nearly_grazing > 0);
  }
}

TEST_CASE("SixSidesSeeAllOfASphere") {
  const VirtualScannerOptions options = scans_of(Shape::kSphere, 20000, 6);
  const VirtualScanner scanner(options);
  const PointCloud cloud = all_of(*scanner.all());
  const PointTree tree(cloud.positions);
  SyntheticOptions dense = options.surface;
  dense.points = 100'003;
  SyntheticCloud surface(dense);
  double gap = 0.0;
  for (const Vec3& p : all_of(surface).positions)
    gap = std::max(gap, std::sqrt(tree.nearest(p).squared_distance));
  CHECK(gap < 0.9 * scanner.ray_distance());
}

TEST_CASE("ATorusHidesPartOfItsInnerRimFromSixSidesAndNothingElse", "[costly]") {
  const VirtualScannerOptions options = scans_of(Shape::kTorus, 40000, 6);
  const VirtualScanner scanner(options);
  const PointCloud cloud = all_of(*scanner.all());
  const PointTree tree(cloud.positions);
  SyntheticOptions dense = options.surface;
  dense.points = 20'011;
  SyntheticCloud surface(dense);
  std::size_t unseen = 0, missing = 0, invented = 0;
  for (const Vec3& p : all_of(surface).positions) {
    double best = -1.0;  // cosine of the best of the free views
    for (int scan = 0; scan < 6; ++scan) {
      const Vec3 direction = scanner.pose(scan).motion.direction({0.0, 0.0, 1.0});
      if (is_free(options, p, direction)) best = std::max(best, cosine_of(options, p, direction));
    }
    const double nearest = std::sqrt(tree.nearest(p).squared_distance) / scanner.ray_distance();
    unseen += best < kGrazing;
    missing += best > kGrazing + 0.05 && nearest > 2.5;
    invented += best < kGrazing - 0.05 && nearest < 0.5;
    if (best < kGrazing) CHECK(std::hypot(p.x, p.y) < 0.62);
  }
  CHECK(unseen > 200);
  CHECK(missing == 0);
  CHECK(invented == 0);
}

TEST_CASE("OpenSheetsAreSeenFromTheirOuterSideOnly") {
  const VirtualScanner plane(scans_of(Shape::kPlane, 1000, 6));
  CHECK(plane.points(0) == plane.points());
  const VirtualScanner walls(scans_of(Shape::kDoubleWall, 1000, 6));
  CHECK(walls.points(0) > 400);
  CHECK(walls.points(1) > 400);
  CHECK(walls.points(0) + walls.points(1) == walls.points());
}

TEST_CASE("ScannerNoiseIsAlongTheRayAndHasTheStatedDeviation", "[costly]") {
  VirtualScannerOptions options = scans_of(Shape::kBumpyTorus, 100000, 6);
  const VirtualScanner still(options);
  options.surface.noise = 0.4;
  const VirtualScanner noisy(options);
  double sum = 0.0, squares = 0.0, n = 0.0;
  std::size_t moved_sideways = 0;
  for (int scan = 0; scan < 6; ++scan) {
    const PointCloud a = all_of(*still.scan(scan)), b = all_of(*noisy.scan(scan));
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      const Vec3 d = (b.positions[i] - a.positions[i]) / still.ray_distance();
      moved_sideways += d.x != 0.0 || d.y != 0.0;
      sum += d.z;
      squares += d.z * d.z;
      n += 1.0;
    }
  }
  CHECK(moved_sideways == 0);
  CHECK(std::abs(sum / n) < 5 * 0.4 / std::sqrt(n));
  CHECK(std::sqrt(squares / n) == Approx(0.4).epsilon(0.01));
}

TEST_CASE("MisregistrationIsRigidAndDisplacesByTheStatedRootMeanSquare") {
  for (const Shape shape : {Shape::kTorus, Shape::kCube}) {
    VirtualScannerOptions options = scans_of(shape, 50000, 8);
    const VirtualScanner true_scans(options);
    options.misregistration = 1.5;
    const VirtualScanner scanner(options);
    std::vector<Vec3> first_moves;
    for (int scan = 0; scan < 8; ++scan) {
      const PointCloud own = all_of(*scanner.scan(scan));
      CHECK(own.positions == all_of(*true_scans.scan(scan)).positions);
      const RigidMotion& moved = scanner.pose(scan).motion;
      const RigidMotion& truth = true_scans.pose(scan).motion;
      double squares = 0.0, off_rigid = 0.0;
      for (const Vec3& p : own.positions) {
        squares += squared_norm(moved.point(p) - truth.point(p));
        const Vec3 from_first = p - own.positions.front();
        off_rigid =
            std::max(off_rigid, std::abs(norm(moved.direction(from_first)) - norm(from_first)));
      }
      const double rms = std::sqrt(squares / static_cast<double>(own.size()));
      INFO(name_of(shape) << " " << scan);
      CHECK(rms == Approx(1.5 * scanner.ray_distance()).epsilon(0.02));
      CHECK(off_rigid < 1e-14);
      // By a turn, too, not by a shift alone.
      CHECK(norm(moved.rows[0] - truth.rows[0]) + norm(moved.rows[1] - truth.rows[1]) >
            0.1 * scanner.ray_distance());
      first_moves.push_back(moved.point({}) - truth.point({}));
    }
    for (std::size_t k = 1; k < first_moves.size(); ++k)
      CHECK(norm(first_moves[k] - first_moves[0]) > 0.05 * scanner.ray_distance());
  }
}

TEST_CASE("MergedScansAreThePosedScansToTheLastBit") {
  VirtualScannerOptions options = scans_of(Shape::kCube, 3000, 7);
  options.surface.noise = 0.2;
  options.misregistration = 0.5;
  const VirtualScanner scanner(options);
  for (const std::size_t batch : {1u, 333u, 100000u}) {
    const PointCloud merged = all_of(*scanner.all(), batch);
    std::size_t at = 0;
    for (int scan = 0; scan < 7; ++scan) {
      const PointCloud own = all_of(*scanner.scan(scan), batch);
      CHECK(own.size() == scanner.points(scan));
      for (const Vec3& p : own.positions) {
        REQUIRE(merged.positions.at(at) == scanner.pose(scan).motion.point(p));
        REQUIRE(attribute_value(merged, at, 0) == scan);
        ++at;
      }
    }
    CHECK(at == merged.size());
  }
}

TEST_CASE("PosesAreQuaternionsOfStanfordsConvention") {
  VirtualScannerOptions options = scans_of(Shape::kSphere, 500, 5);
  options.misregistration = 1.0;
  const VirtualScanner scanner(options);
  for (int scan = 0; scan < 5; ++scan) {
    const ScannerPose& pose = scanner.pose(scan);
    const auto [x, y, z, w] = pose.quaternion;
    CHECK(pose.motion == motion_of_quaternion({-x, -y, -z, w}, pose.translation));
    CHECK(x * x + y * y + z * z + w * w == Approx(1.0).epsilon(1e-14));
  }
}

TEST_CASE("ScansAreTheSameBitsOnEveryMachine", "[costly]") {
  const std::map<Shape, std::uint64_t> expected = {
      {Shape::kSphere, 0x361e904ea27f84e8},        {Shape::kTorus, 0x2e54331aad930c1c},
      {Shape::kBumpyTorus, 0x4d59a573d5b9ad7e},    {Shape::kPlane, 0xbaf44caf7cb81f8a},
      {Shape::kDoubleWall, 0x0628c6b409cebacf},    {Shape::kCube, 0x36b703358a2cc7cb},
      {Shape::kTwoComponents, 0x7bb4fd231224ce95}, {Shape::kGenusThree, 0xca37715b2f5ba128}};
  for (const Shape shape : all_shapes()) {
    VirtualScannerOptions options = scans_of(shape, 2000, 6);
    options.surface.noise = 0.1;
    options.misregistration = 0.3;
    PointCloud both = all_of(*VirtualScanner(options).all());
    options.scans = 11;
    options.surface.seed = 2;
    both.append(all_of(*VirtualScanner(options).all()));
    INFO(name_of(shape) << std::hex << " 0x" << test::fingerprint(both));
    CHECK(test::fingerprint(both) == expected.at(shape));
  }
}

TEST_CASE("WrongScannerOptionsAreUsageErrors") {
  const auto refused = [](auto change) {
    VirtualScannerOptions options = scans_of(Shape::kPlane, 100, 6);
    change(options);
    CHECK_THROWS_AS(VirtualScanner(options), Error);
  };
  refused([](auto& o) { o.scans = 0; });
  refused([](auto& o) { o.scans = 256; });
  refused([](auto& o) { o.misregistration = -0.1; });
  refused([](auto& o) { o.misregistration = std::numeric_limits<double>::infinity(); });
  refused([](auto& o) { o.surface.points = 0; });
  refused([](auto& o) { o.surface.noise = -1.0; });
  refused([](auto& o) { o.surface.density_varying = true; });
}

}  // namespace orbweave
