#include "engine/synthetic/scene_scanner.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "engine/geometry/triangle_tree.h"
#include "engine/synthetic/portable_math.h"
#include "engine/synthetic/scene_rays.h"
#include "io/error.h"

namespace orbweave {
namespace {

using synthetic::SceneRole;

SceneScannerOptions options_of(SceneKind scene, std::uint64_t points) {
  SceneScannerOptions options;
  options.scene = scene;
  options.points = points;
  return options;
}

PointCloud all_of(PointSource& source, std::size_t batch_points = 4096) {
  PointCloud batch, all;
  all.schema = source.schema();
  while (source.read(batch, batch_points)) all.append(batch);
  return all;
}

/// What stops rays and belongs to the truth: no panes, no trunks.
TriangleMesh seen_truth(const synthetic::Scene& scene) {
  synthetic::Scene seen = scene;
  std::erase_if(seen.triangles,
                [](const auto& triangle) { return triangle.role != SceneRole::kSurface; });
  return truth_mesh(seen);
}

/// A random direction, and with another word a random place in a box.
Vec3 random_vector(std::uint64_t word) { return portable::gaussian(17, word); }

}  // namespace

TEST_CASE("PointsOfUndisturbedScenesLieOnTheTruthAndFaceTheScanner", "[costly]") {
  for (const SceneKind kind : all_scenes()) {
    SceneScannerOptions options = options_of(kind, 20000);
    options.disturbances = false;
    const SceneScanner scanner(options);
    INFO(name_of(kind));
    CHECK(static_cast<double>(scanner.points()) == Approx(20000).epsilon(0.05));
    const TriangleMesh truth = seen_truth(scanner.scene());
    const TriangleTree tree(truth);
    const auto source = scanner.all();
    double farthest = 0.0;
    std::size_t behind = 0, trunks = 0;
    for (PointCloud batch; source->read(batch, 1000);)
      for (const Vec3 p : batch.positions) {
        const TriangleTree::Nearest nearest = tree.nearest(p);
        const double distance = std::sqrt(nearest.squared_distance);
        // Trunks of trees stop rays and do not belong to the truth.
        const bool is_trunk = kind == SceneKind::kHouse && distance > 0.1;
        trunks += is_trunk ? 1 : 0;
        if (is_trunk) continue;
        farthest = std::max(farthest, distance);
        const Triangle& t = truth.triangles[nearest.item];
        const Vec3 normal = truth.vertices.normals[t[0]];
        const Vec3 towards =
            kind == SceneKind::kRoom ? source->scanner()->vector - p : Vec3{0, 0, 120} - p;
        // Points on an edge may have either of its triangles as the nearest.
        if (kind == SceneKind::kRoom && dot(normal, towards) < -1e-9 * norm(towards)) ++behind;
      }
    CHECK(farthest < 1e-9);
    CHECK(behind < 20);
    CHECK(trunks < 50);
  }
}

TEST_CASE("ScansOfScenesAreTheSameBitsForEveryBatchSizeAndByTheirPoses", "[costly]") {
  SceneScannerOptions options = options_of(SceneKind::kRoom, 5000);
  options.noise = 0.3;
  options.misregistration = 0.5;
  const SceneScanner scanner(options);
  const PointCloud all = all_of(*scanner.all(), 999);
  CHECK(all.positions == all_of(*SceneScanner(options).all(), 100000).positions);
  REQUIRE(scanner.scans() == 4);
  std::vector<Vec3> world;
  for (int scan = 0; scan < 4; ++scan) {
    CHECK(scanner.scanner(scan)->vector == Vec3{});
    CHECK_FALSE(scanner.scanner(scan)->is_direction);
    for (const Vec3 p : all_of(*scanner.scan(scan)).positions)
      world.push_back(scanner.pose(scan).motion.point(p));
  }
  CHECK(world == all.positions);
}

TEST_CASE("NoPointOfARoomLiesOnAPaneOrBehindIt") {
  SceneScannerOptions options = options_of(SceneKind::kRoom, 20000);
  options.disturbances = false;  // pixels that mix two surfaces lie anywhere between them
  const SceneScanner scanner(options);
  const PointCloud cloud = all_of(*scanner.all());
  std::size_t outside = 0;
  for (const Vec3 p : cloud.positions)
    outside += p.y < -0.0399 || p.y > 5.0399 || p.x > 6.0399 ? 1 : 0;
  CHECK(outside == 0);
  const auto panes = std::ranges::max(scanner.scene().triangles, {}, [](const auto& triangle) {
                       return triangle.pane;
                     }).pane;
  CHECK(panes == 14);
}

TEST_CASE("DisturbancesOfARoomAreMixedPixelsAndWalkersOfTwoScans", "[costly]") {
  const SceneScannerOptions options = options_of(SceneKind::kRoom, 40000);
  const SceneScanner scanner(options);
  const TriangleMesh truth = seen_truth(scanner.scene());
  const TriangleTree tree(truth);
  struct Count {
    std::size_t off = 0, on_walker = 0;
  };
  // Points away from the truth, and those of them within reach of a walker's way.
  const auto count_of = [&](int scan, const synthetic::Walker& walker) {
    Count count;
    const Vec3 way = walker.to - walker.from;
    for (const Vec3 own : all_of(*scanner.scan(scan)).positions) {
      const Vec3 p = scanner.pose(scan).motion.point(own);
      if (tree.squared_distance(p) < 0.01) continue;
      ++count.off;
      const double along = std::clamp(dot(p - walker.from, way) / squared_norm(way), 0.0, 1.0);
      const Vec3 from_way = p - walker.from - along * way;
      const Vec3 level{from_way.x, from_way.y, 0.0};
      count.on_walker += norm(level) < walker.radius + 1e-9 ? 1 : 0;
    }
    return count;
  };
  for (const synthetic::Walker& walker : scanner.scene().walkers) {
    const Count seen = count_of(static_cast<int>(walker.scan), walker), other = count_of(0, walker);
    CHECK(seen.on_walker > 20);
    CHECK(seen.on_walker > 3 * other.on_walker);
    CHECK(other.off > 0);  // mixed pixels
    CHECK(static_cast<double>(other.off) < 0.02 * static_cast<double>(scanner.points(0)));
  }
}

TEST_CASE("LeavesOfTheHouseAreAboveTheGround", "[costly]") {
  const SceneScanner scanner(options_of(SceneKind::kHouse, 40000));
  const PointCloud cloud = all_of(*scanner.all());
  const synthetic::Crown& crown = scanner.scene().crowns.front();
  std::size_t leaves = 0, below = 0;
  for (const Vec3 p : cloud.positions) {
    leaves += norm(p - crown.center) < crown.radius ? 1 : 0;
    const Vec3 level{p.x - crown.center.x, p.y - crown.center.y, 0.0};
    below += norm(level) < crown.radius && p.z < 1.5 ? 1 : 0;
  }
  CHECK(leaves > 100);
  CHECK(below > 50);
}

TEST_CASE("NoiseOfASceneGrowsWithTheDistanceWhereItIsToldTo", "[costly]") {
  for (const int growth : {0, 2}) {
    SceneScannerOptions options = options_of(SceneKind::kRoom, 40000);
    options.disturbances = false;
    const PointCloud clean = all_of(*SceneScanner(options).scan(0));
    options.noise = 0.2;
    options.noise_growth = growth;
    const SceneScanner scanner(options);
    const PointCloud noisy = all_of(*scanner.scan(0));
    REQUIRE(noisy.size() == clean.size());
    struct Sum {
      double squares = 0.0, count = 0.0;
      double deviation() const { return std::sqrt(squares / count); }
    } near, far;
    for (std::size_t k = 0; k < clean.size(); ++k) {
      const double distance = norm(clean.positions[k]);
      if (distance > 2.0 && distance < 4.0) continue;
      Sum& sum = distance <= 2.0 ? near : far;
      sum.squares += squared_norm(noisy.positions[k] - clean.positions[k]);
      sum.count += 1.0;
    }
    REQUIRE(std::min(near.count, far.count) > 500.0);
    if (growth == 0) {
      CHECK(near.deviation() == Approx(0.2 * scanner.spacing()).epsilon(0.1));
      CHECK(far.deviation() == Approx(near.deviation()).epsilon(0.1));
    } else {
      CHECK(far.deviation() > 4.0 * near.deviation());
    }
  }
}

TEST_CASE("RaysOfSceneTreesHitWhatAllTrianglesTogetherDo") {
  const synthetic::Scene scene = synthetic::room_scene();
  const synthetic::SceneRays tree(scene.triangles);
  std::size_t different = 0;
  for (std::uint64_t k = 0; k < 500; ++k) {
    const Vec3 origin{3.0 + 0.5 * random_vector(2 * k).x, 3.0 + 0.3 * random_vector(2 * k).y, 1.5};
    const Vec3 direction = normalized(random_vector(2 * k + 1));
    double nearest = std::numeric_limits<double>::infinity();
    for (const synthetic::SceneTriangle& triangle : scene.triangles) {
      const auto one = synthetic::SceneRays({&triangle, 1}).first_hit(origin, direction);
      if (one) nearest = std::min(nearest, one->distance);
    }
    const auto hit = tree.first_hit(origin, direction);
    different += (hit ? hit->distance : std::numeric_limits<double>::infinity()) != nearest ? 1 : 0;
  }
  CHECK(different == 0);
}

TEST_CASE("OptionsOfScenesOutOfRangeAreUsageErrors") {
  const auto refuses = [](auto change) {
    SceneScannerOptions options = options_of(SceneKind::kRoom, 2000);
    change(options);
    CHECK_THROWS_AS(SceneScanner(options), Error);
  };
  refuses([](SceneScannerOptions& o) { o.points = 999; });
  refuses([](SceneScannerOptions& o) { o.noise = -0.1; });
  refuses([](SceneScannerOptions& o) { o.noise_growth = 3; });
  refuses(
      [](SceneScannerOptions& o) { o.misregistration = std::numeric_limits<double>::quiet_NaN(); });
}

}  // namespace orbweave
