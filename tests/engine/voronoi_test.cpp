// The Voronoi family on shapes whose surface is known, and on real models.
#include "engine/voronoi/voronoi.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "engine/synthetic/synthetic_cloud.h"
#include "engine/validation/mesh_facts.h"
#include "engine/voronoi/undersampling.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/meshes.h"

using namespace orbweave;
using namespace orbweave::test;
namespace vor = orbweave::voronoi;

namespace {

bool comes_first(const Vec3& a, const Vec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// In the order of the coordinates, each place once.
std::vector<Vec3> distinct(std::vector<Vec3> points) {
  std::sort(points.begin(), points.end(), comes_first);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

std::vector<Vec3> sample(Shape shape, std::uint64_t count) {
  SyntheticOptions options;
  options.shape = shape;
  options.points = count;
  SyntheticCloud source(options);
  PointCloud cloud;
  source.read(cloud, count);
  return distinct(std::move(cloud.positions));
}

MeshFacts facts_of(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  TriangleMesh mesh;
  mesh.vertices.positions = points;
  mesh.triangles = triangles;
  return mesh_facts(mesh);
}

double volume(const std::vector<Vec3>& points, const std::vector<Triangle>& triangles) {
  double sum = 0.0;
  for (const Triangle& t : triangles)
    sum += dot(points[t[0]], cross(points[t[1]], points[t[2]])) / 6.0;
  return sum;
}

/// Whether no directed edge has two triangles, and every one has another that runs back.
bool has_two_triangles_at_each_edge(const std::vector<Triangle>& triangles) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k)
      if (!edges.emplace(t[k], t[(k + 1) % 3]).second) return false;
  return std::ranges::all_of(edges, [&](const auto& edge) {
    return edges.contains({edge.second, edge.first});
  });
}

/// Whether every edge has an even number of triangles, as many in one direction as in the other.
bool is_watertight(const std::vector<Triangle>& triangles) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  return !triangles.empty() &&
         std::all_of(balance.begin(), balance.end(), [](const auto& e) { return e.second == 0; });
}

void require_closed_manifold(const std::vector<Vec3>& points,
                             const std::vector<Triangle>& triangles, int components, int genus) {
  const MeshFacts facts = facts_of(points, triangles);
  CHECK(facts.watertight);
  CHECK(facts.boundary_edges == 0);
  CHECK(facts.nonmanifold_edges == 0);
  CHECK(facts.components == static_cast<std::uint64_t>(components));
  CHECK(facts.euler_characteristic == 2 * components - 2 * genus);
  CHECK(facts.vertices == points.size());
  CHECK(volume(points, triangles) > 0.0);
}

using Method = std::function<std::vector<Triangle>(const std::vector<Vec3>&)>;

/// The methods whose vertices are the points, as manifolds.
std::vector<std::pair<std::string, Method>> manifold_methods() {
  return {{"cocone", [](const auto& points) { return vor::cocone(points).triangles; }},
          {"tight_cocone", [](const auto& points) { return vor::tight_cocone(points).triangles; }},
          {"crust", [](const auto& points) {
             return vor::crust(points, {.extracts_manifold = true}).triangles;
           }}};
}

/// The Power Crust's triangles over its own vertices, too.
std::vector<std::pair<std::string, Method>> all_methods() {
  auto methods = manifold_methods();
  methods.emplace_back("power_crust", [](const auto& points) {
    return vor::triangles_of(vor::power_crust(points));
  });
  return methods;
}

/// Whatever there is of a surface: corners that are there and differ, no more than two triangles at
/// an edge. The Power Crust numbers its own vertices.
void require_sound(const std::vector<Triangle>& triangles, const std::vector<Vec3>& points) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  bool is_simple = true;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      is_simple = is_simple && a != b && edges.emplace(a, b).second;
    }
  CHECK(is_simple);
  CHECK(triangles.size() < 40 * points.size());
}

void require_closed_manifolds(const std::vector<Vec3>& points, int components, int genus) {
  for (const auto& [name, method] : manifold_methods()) {
    INFO(name << ", " << points.size() << " points");
    require_closed_manifold(points, method(points), components, genus);
  }
  const vor::PowerCrustSurface power = vor::power_crust(points);
  const std::vector<Triangle> triangles = vor::triangles_of(power);
  INFO("power_crust");
  CHECK(is_watertight(triangles));
  CHECK(has_two_triangles_at_each_edge(triangles));
  CHECK(volume(power.vertices, triangles) > 0.0);
}

std::vector<Vec3> stanford(const std::string& name) {
  const auto file = data_path("stanford/" + name);
  if (skipped_without(file)) return {};
  const auto source = open_point_source(file.string(), {});
  PointCloud cloud, batch;
  while (source->read(batch, 1 << 16))
    cloud.positions.insert(cloud.positions.end(), batch.positions.begin(), batch.positions.end());
  return distinct(std::move(cloud.positions));
}

/// Without the points in some balls around points of the cloud.
std::vector<Vec3> with_discs_removed(const std::vector<Vec3>& points, double share) {
  Random random(7);
  Box box;
  for (const Vec3 p : points) box.extend(p);
  std::vector<Vec3> centers;
  for (int i = 0; i < 6; ++i) centers.push_back(points[random.below(points.size())]);
  std::vector<Vec3> kept;
  for (const Vec3 p : points)
    if (std::none_of(centers.begin(), centers.end(),
                     [&](Vec3 c) { return norm(p - c) < share * box.largest_extent(); }))
      kept.push_back(p);
  return kept;
}

void require_watertight(const std::vector<Vec3>& points) {
  const std::vector<Triangle> tight = vor::tight_cocone(points).triangles;
  CHECK(is_watertight(tight));
  const MeshFacts facts = facts_of(points, tight);
  CHECK(facts.boundary_edges == 0);
  CHECK(facts.nonmanifold_edges == 0);
  const vor::PowerCrustSurface power = vor::power_crust(points);
  const std::vector<Triangle> crust = vor::triangles_of(power);
  CHECK(is_watertight(crust));
  CHECK(has_two_triangles_at_each_edge(crust));
}

}  // namespace

TEST_CASE("VoronoiMethodsCloseASphere") {
  require_closed_manifolds(sample(Shape::kSphere, 3'000), 1, 0);
}

TEST_CASE("VoronoiMethodsCloseATorus", "[costly]") {
  require_closed_manifolds(sample(Shape::kTorus, 4'000), 1, 1);
  require_closed_manifolds(sample(Shape::kBumpyTorus, 4'000), 1, 1);
}

TEST_CASE("VoronoiMethodsCloseTwoComponents", "[costly]") {
  require_closed_manifolds(sample(Shape::kTwoComponents, 4'000), 2, 1);
}

TEST_CASE("VoronoiMethodsCloseASurfaceOfGenusThree", "[costly]") {
  require_closed_manifolds(sample(Shape::kGenusThree, 8'000), 1, 3);
}

TEST_CASE("CoconeLeavesTheBorderOfASheetOpen") {
  const std::vector<Vec3> torus = sample(Shape::kTorus, 4'000);
  std::vector<Vec3> half;
  for (const Vec3 p : torus)
    if (p.x > 0.0) half.push_back(p);
  const MeshFacts facts = facts_of(half, vor::cocone(half).triangles);
  CHECK(facts.nonmanifold_edges == 0);
  CHECK(facts.components == 1);
  CHECK(facts.boundary_edges > 20);
  CHECK(facts.triangles > 19 * half.size() / 10);
  CHECK(is_watertight(vor::tight_cocone(half).triangles));
}

TEST_CASE("UndersampledPlacesAreWhereTheSurfaceEnds") {
  const std::vector<Vec3> whole = sample(Shape::kSphere, 4'000);
  const vor::Undersampling nothing = vor::find_undersampling(whole);
  CHECK(nothing.well_sampled.size() == whole.size());
  CHECK(nothing.points == 0);
  CHECK(nothing.places.empty());

  std::vector<Vec3> open;
  for (const Vec3 p : whole)
    if (p.z < 0.3) open.push_back(p);
  const vor::Undersampling found = vor::find_undersampling(open);
  REQUIRE_FALSE(found.places.empty());
  std::uint64_t listed = 0;
  for (const vor::UndersampledPlace& place : found.places) {
    listed += place.points;
    CHECK(place.bounds.min.z > 0.1);
    CHECK(place.points <= found.places.front().points);
  }
  CHECK(listed == found.points);
  CHECK(listed == static_cast<std::uint64_t>(
                      std::count(found.well_sampled.begin(), found.well_sampled.end(), 0)));
  CHECK((found.well_sampled == vor::cocone(open).well_sampled));
}

TEST_CASE("UndersampledPlacesAndCoconeAreTheSameAtAnyScale") {
  std::vector<Vec3> open;
  for (const Vec3 p : sample(Shape::kTorus, 2'000))
    if (p.x > 0.0) open.push_back(p);
  const vor::PointSurface expected = vor::cocone(open);
  REQUIRE_FALSE(expected.triangles.empty());
  for (const int exponent : {-200, 200}) {  // far below and above the range of floats
    std::vector<Vec3> scaled;
    for (const Vec3 p : open) scaled.push_back(std::ldexp(1.0, exponent) * p);
    INFO("exponent " << exponent);
    const vor::PointSurface found = vor::cocone(scaled);
    CHECK((found.well_sampled == expected.well_sampled));
    CHECK((found.triangles == expected.triangles));
  }
}

TEST_CASE("PowerCrustFindsTheMedialAxisOfASphere") {
  const vor::PowerCrustSurface surface = vor::power_crust(sample(Shape::kSphere, 2'000));
  REQUIRE_FALSE(surface.medial_axis.empty());
  for (const vor::MedialBall& ball : surface.medial_axis) {
    CHECK(norm(ball.center) < 0.05);
    CHECK(std::abs(ball.radius - 1.0) < 0.05);
  }
  for (const Vec3 p : surface.vertices) CHECK(std::abs(norm(p) - 1.0) < 0.01);
}

TEST_CASE("PowerCrustVerticesCarryANearSample") {
  const std::vector<Vec3> points = sample(Shape::kBumpyTorus, 3'000);
  const vor::PowerCrustSurface surface = vor::power_crust(points);
  constexpr double kSpacing = 0.073;
  REQUIRE(surface.samples.size() == surface.vertices.size());
  for (std::size_t i = 0; i < surface.samples.size(); ++i) {
    REQUIRE(surface.samples[i] < points.size());
    CHECK(norm(points[surface.samples[i]] - surface.vertices[i]) < 2.0 * kSpacing);
  }
}

// Centres are rounded in the order of the corners, so that this holds of points in general
// position; jobs bring their points into canonical order first.
TEST_CASE("VoronoiTrianglesDoNotDependOnTheOrderOfThePoints") {
  const std::vector<Vec3> points = sample(Shape::kBumpyTorus, 2'000);
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  Random random(3);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  std::vector<Vec3> shuffled;
  for (const std::uint32_t i : order) shuffled.push_back(points[i]);
  for (const auto& [name, method] : manifold_methods()) {
    INFO(name);
    std::vector<Triangle> triangles = method(shuffled);
    for (Triangle& t : triangles)
      t = smallest_first(Triangle{order[t[0]], order[t[1]], order[t[2]]});
    std::sort(triangles.begin(), triangles.end());
    CHECK((triangles == method(points)));
  }
}

TEST_CASE("VoronoiMethodsDecideTies") {
  // Cospherical everywhere.
  const std::vector<Vec3> points = distinct(torus_mesh(1'000).vertices.positions);
  require_closed_manifolds(points, 1, 1);
}

TEST_CASE("VoronoiMethodsRefuseWhatHasNoVolume") {
  std::vector<Vec3> line, plane;
  for (int i = 0; i < 10; ++i) line.push_back({1.0 * i, 2.0 * i, 3.0 * i});
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j) plane.push_back({1.0 * i, 1.0 * j, 0.0});
  const std::vector<std::vector<Vec3>> flat = {
      {}, {{1, 2, 3}}, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, line, plane};
  for (const auto& points : flat) {
    for (const auto& [name, method] : manifold_methods()) {
      INFO(name << ", " << points.size() << " points");
      CHECK_THROWS_AS(method(points), Error);
    }
    CHECK_THROWS_AS(vor::power_crust(points), Error);
  }
}

TEST_CASE("VoronoiMethodsTakeFivePoints") {
  const std::vector<Vec3> points = {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {1, 1, 1}};
  for (const auto& [name, method] : all_methods()) {
    INFO(name);
    require_sound(method(points), points);
  }
  const std::vector<Triangle> hull = vor::tight_cocone(points).triangles;
  CHECK((hull.empty() || volume(points, hull) > 0.0));
}

TEST_CASE("VoronoiMethodsTakeAPlaneWithOnePointBesideIt") {
  std::vector<Vec3> points = {{2.5, 2.5, 1.0}};
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) points.push_back({1.0 * i, 1.0 * j, 0.0});
  points = distinct(std::move(points));
  for (const auto& [name, method] : all_methods()) {
    INFO(name);
    require_sound(method(points), points);
  }
}

TEST_CASE("VoronoiMethodsTakeAFullGrid") {
  // No surface at all, and cospherical everywhere.
  std::vector<Vec3> points;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      for (int k = 0; k < 6; ++k) points.push_back({1.0 * i, 1.0 * j, 1.0 * k});
  for (const auto& [name, method] : all_methods()) {
    INFO(name);
    require_sound(method(points), points);
  }
}

TEST_CASE("VoronoiMethodsTakeTheSurfaceOfAGrid") {
  std::vector<Vec3> points;
  constexpr int kSide = 8;
  for (int i = 0; i <= kSide; ++i)
    for (int j = 0; j <= kSide; ++j)
      for (int k = 0; k <= kSide; ++k)
        if (i % kSide == 0 || j % kSide == 0 || k % kSide == 0)
          points.push_back({1.0 * i, 1.0 * j, 1.0 * k});
  const std::vector<Triangle> triangles = vor::tight_cocone(points).triangles;
  CHECK(is_watertight(triangles));
  CHECK(volume(points, triangles) == Approx(kSide * kSide * kSide).epsilon(0.05));
  for (const auto& [name, method] : manifold_methods()) CHECK_NOTHROW(method(points));
  const vor::PowerCrustSurface power = vor::power_crust(points);
  const std::vector<Triangle> crust = vor::triangles_of(power);
  CHECK(has_two_triangles_at_each_edge(crust));
  CHECK(volume(power.vertices, crust) == Approx(kSide * kSide * kSide).epsilon(0.05));
}

TEST_CASE("VoronoiMethodsKeepTheirResultFarFromTheOrigin") {
  const std::vector<Vec3> near = sample(Shape::kTorus, 2'000);
  for (const double size : {1.0, 1e6, 1e-6}) {
    std::vector<Vec3> far;
    for (const Vec3 p : near) far.push_back(size * p + Vec3{1e6, -2e6, 3e6} * std::max(1.0, size));
    if (size < 1.0)
      for (std::size_t i = 0; i < far.size(); ++i) far[i] = size * near[i];
    far = distinct(std::move(far));
    INFO("size " << size);
    for (const auto& [name, method] : manifold_methods()) {
      INFO(name);
      require_closed_manifold(far, method(far), 1, 1);
    }
    const vor::PowerCrustSurface power = vor::power_crust(far);
    CHECK(has_two_triangles_at_each_edge(vor::triangles_of(power)));
  }
}

TEST_CASE("VoronoiMethodsPassOverDuplicates") {
  std::vector<Vec3> points = sample(Shape::kSphere, 500);
  const std::size_t count = points.size();
  std::vector<std::vector<Triangle>> expected;
  for (const auto& [name, method] : all_methods()) expected.push_back(method(points));
  points.insert(points.end(), points.begin(), points.begin() + 100);
  std::size_t next = 0;
  for (const auto& [name, method] : all_methods()) {
    INFO(name << ", " << count << " points and 100 again");
    CHECK((method(points) == expected[next++]));
  }
}

TEST_CASE("VoronoiMethodsStopWhenAsked") {
  StopToken stop;
  stop.request();
  const std::vector<Vec3> points = sample(Shape::kSphere, 500);
  CHECK_THROWS_AS(vor::cocone(points, {}, &stop), Error);
  CHECK_THROWS_AS(vor::tight_cocone(points, &stop), Error);
  CHECK_THROWS_AS(vor::crust(points, {}, &stop), Error);
  CHECK_THROWS_AS(vor::power_crust(points, {}, &stop), Error);
}

TEST_CASE("WatertightMethodsCloseTheBunny") {
  for (const char* name : {"bun_zipper_res4.ply", "bun_zipper_res3.ply"}) {
    const std::vector<Vec3> points = stanford(name);
    if (points.empty()) return;
    INFO(name);
    require_watertight(points);
    require_watertight(with_discs_removed(points, 0.06));
  }
}

TEST_CASE("WatertightMethodsCloseAllStanfordModels", "[slow]") {
  for (const char* name : {"bun_zipper_res2.ply", "bun_zipper.ply", "dragon_vrip_res4.ply",
                           "dragon_vrip_res3.ply", "dragon_vrip_res2.ply"}) {
    const std::vector<Vec3> points = stanford(name);
    if (points.empty()) return;
    INFO(name);
    require_watertight(points);
    require_watertight(with_discs_removed(points, 0.04));
  }
}

TEST_CASE("PowerCrustHasThePublishedSize") {
  const std::vector<Vec3> points = stanford("bun_zipper_res3.ply");
  if (points.empty()) return;
  const vor::PowerCrustSurface surface = vor::power_crust(points);
  CHECK(static_cast<double>(surface.vertices.size()) == Approx(17272).epsilon(0.15));
  CHECK(static_cast<double>(surface.polygons()) == Approx(12085).epsilon(0.15));
}
