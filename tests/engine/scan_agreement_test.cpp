// Scans that overlap lie on one surface, or it is told which one does not.
#include "engine/validation/scan_agreement.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "tests/support/clouds.h"

namespace orbweave {
namespace {

using Scanners = std::vector<std::optional<ScannerPlace>>;

/// A whole cloud as one site, with the scan of each point.
struct Scene {
  SpacingSite site;
  std::vector<std::uint32_t> scans;

  Scene() {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    site.core = site.box = {{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  }
  void add(Vec3 p, std::uint32_t scan) {
    site.points.push_back(p);
    scans.push_back(scan);
  }
  std::vector<OffScan> off(const Scanners& scanners) const {
    return scans_off_surface({&site, 1}, {&scans, 1}, scanners);
  }
};

/// Points of a sphere of radius 1 that a scan sees from a direction; moved.
void add_view(Scene& scene, std::uint32_t scan, Vec3 from, Vec3 by, test::Random& random) {
  for (int i = 0; i < 5000; ++i) {
    const double z = 2.0 * random.uniform() - 1.0;
    const double turn = 2.0 * std::numbers::pi * random.uniform();
    const double r = std::sqrt(1.0 - z * z);
    const Vec3 p{r * std::cos(turn), r * std::sin(turn), z};
    if (dot(p, from) > 0.2) scene.add(p + by, scan);
  }
}

const Scanners kThreeSides = {ScannerPlace{{10, 0, 0}, false}, ScannerPlace{{0, 10, 0}, false},
                              ScannerPlace{{0, 0, 1}, true}};

Scene three_views(Vec3 by) {
  test::Random random(7);
  Scene scene;
  add_view(scene, 0, {1, 0, 0}, {}, random);
  add_view(scene, 1, {0, 1, 0}, by, random);
  add_view(scene, 2, {0, 0, 1}, {}, random);
  return scene;
}

TEST_CASE("ViewsOfOneSurfaceAgree") {
  CHECK(three_views({}).off(kThreeSides).empty());
  CHECK(three_views({}).off(Scanners(3)).empty());
}

TEST_CASE("AViewThatWasMovedDoesNotAgree") {
  for (const double by : {0.3, 0.6}) {  // the points lie 0.05 apart
    const Scene scene = three_views({-0.6 * by, 0.64 * by, 0.48 * by});
    for (const Scanners& scanners : {kThreeSides, Scanners(3)}) {
      const std::vector<OffScan> off = scene.off(scanners);
      if (scanners[0]) REQUIRE(off.size() == 1);
      for (const OffScan& one : off) CHECK(one.scan == 1);
    }
  }
}

TEST_CASE("AgreementDoesNotDependOnTheOrderOfThePoints") {
  const Scene scene = three_views({-0.18, 0.19, 0.14});
  Scene other = scene;
  test::Random random(3);
  for (std::size_t i = other.scans.size(); i > 1; --i) {
    const std::size_t j = random.below(i);
    std::swap(other.site.points[i - 1], other.site.points[j]);
    std::swap(other.scans[i - 1], other.scans[j]);
  }
  const auto a = scene.off(kThreeSides), b = other.off(kThreeSides);
  REQUIRE(a.size() == 1);
  REQUIRE(b.size() == 1);
  CHECK(a[0].scan == b[0].scan);
  CHECK(a[0].meetings == b[0].meetings);
  CHECK(a[0].off == b[0].off);
  CHECK(a[0].distance == b[0].distance);
  CHECK(a[0].spacings == b[0].spacings);
  CHECK(a[0].beside == b[0].beside);
}

/// Two even layers, some spacings apart.
Scene two_layers(double apart) {
  test::Random random(5);
  Scene scene;
  for (std::uint32_t scan = 0; scan < 2; ++scan)
    for (int i = 0; i < 4000; ++i)
      scene.add({64.0 * random.uniform(), 64.0 * random.uniform(), apart * scan}, scan);
  return scene;
}

TEST_CASE("TheTwoSidesOfAPlateAreNotCompared") {
  const ScannerPlace above{{0, 0, 1}, true}, below{{0, 0, -1}, true};
  CHECK(two_layers(4.0).off({below, above}).empty());
  CHECK(two_layers(4.0).off({std::nullopt, std::nullopt}).empty());
  CHECK(two_layers(4.0).off({above, above}).size() == 1);
  CHECK(two_layers(0.0).off({above, above}).empty());
}

/// Ground with a flat hall and loose leaves over it, cut into two tiles.
Scene two_tiles(bool with_leaves) {
  test::Random random(11);
  Scene scene;
  const auto add = [&](Vec3 p) { scene.add(p, p.x < 0.0 ? 0 : 1); };
  for (int i = 0; i < 12000; ++i) {
    const double x = 60.0 * random.uniform() - 30.0, y = 60.0 * random.uniform() - 30.0;
    const bool is_roof = std::abs(x) < 12.0 && std::abs(y) < 12.0;
    add({x, y, is_roof ? 8.0 : 0.0});
  }
  for (int i = 0; with_leaves && i < 12000; ++i)
    add({20.0 * random.uniform() - 10.0, 30.0 * random.uniform() - 15.0,
         2.0 + 12.0 * random.uniform()});
  return scene;
}

TEST_CASE("TilesThatEndAtOneBorderAreNotSaidToCross") {
  for (const bool with_leaves : {false, true})
    CHECK(two_tiles(with_leaves).off({std::nullopt, std::nullopt}).empty());
  const ScannerPlace above{{0, 0, 1}, true};
  CHECK(two_tiles(false).off({above, above}).empty());
}

}  // namespace
}  // namespace orbweave
