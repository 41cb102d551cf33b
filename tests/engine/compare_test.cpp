#include "engine/validation/compare.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <catch2/catch.hpp>

#include "engine/geometry/triangle_tree.h"
#include "engine/synthetic/synthetic_cloud.h"
#include "engine/validation/area_samples.h"
#include "engine/validation/cloud_facts.h"

namespace orbweave {
namespace {

TriangleMesh shape_mesh(Shape shape, std::uint32_t resolution) {
  SyntheticOptions options;
  options.shape = shape;
  return truth_mesh(options, resolution);
}

/// A cloud in memory as a stream.
class MemorySource : public PointSource {
 public:
  explicit MemorySource(PointCloud cloud) : cloud_(std::move(cloud)) {}
  const PointSchema& schema() const override { return cloud_.schema; }
  std::optional<std::uint64_t> declared_points() const override { return cloud_.size(); }
  bool read(PointCloud& batch, std::size_t capacity) override {
    batch.schema = cloud_.schema;
    batch.clear();
    const std::size_t end = std::min(cloud_.size(), next_ + capacity);
    for (; next_ < end; ++next_) batch.append(cloud_, next_);
    return !batch.empty();
  }
  std::uint64_t bytes_read() const override { return next_; }
  std::uint64_t bytes_total() const override { return cloud_.size(); }

 private:
  PointCloud cloud_;
  std::size_t next_ = 0;
};

PointCloud synthetic(Shape shape, std::uint64_t points) {
  SyntheticOptions options;
  options.shape = shape;
  options.points = points;
  SyntheticCloud cloud(options);
  return read_all(cloud);
}

double number(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53 * 2.0 - 1.0;
}
Vec3 place(std::mt19937_64& random) { return {number(random), number(random), number(random)}; }

/// Compares vertices; points spread by area would take most of the time.
MeshComparison by_vertices(const TriangleMesh& a, const TriangleMesh& b,
                           CompareOptions options = {}) {
  options.area_samples = 0;
  return compare_meshes(a, b, options);
}

}  // namespace

TEST_CASE("DistanceToATriangleIsTheSmallestOverItsPoints") {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 p = 2.0 * place(random), a = place(random);
    Vec3 b = place(random), c = place(random);
    if (trial % 10 == 1) c = a + 0.3 * (b - a);  // collinear
    if (trial % 10 == 2) b = c = a;              // a point
    const double exact = std::sqrt(squared_distance_to_triangle(p, a, b, c));
    double sampled = std::numeric_limits<double>::infinity();
    constexpr int kSteps = 60;
    for (int i = 0; i <= kSteps; ++i)
      for (int j = 0; i + j <= kSteps; ++j)
        sampled = std::min(
            sampled, norm(a + (i / double(kSteps)) * (b - a) + (j / double(kSteps)) * (c - a) - p));
    CHECK(exact <= sampled * (1.0 + 1e-12));
    CHECK(exact >= sampled - 0.06);
  }
  CHECK(squared_distance_to_triangle({0.2, 0.2, 5}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}) ==
        Approx(25.0));
  CHECK(squared_distance_to_triangle({-3, -4, 0}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}) == Approx(25.0));
}

TEST_CASE("TriangleTreeFindsTheSameAsComparingWithAllTriangles") {
  std::mt19937_64 random(5);
  for (const std::size_t triangles : {1u, 2u, 7u, 8u, 9u, 100u, 1000u}) {
    TriangleMesh mesh;
    for (std::size_t i = 0; i < triangles; ++i) {
      const Vec3 at = place(random);
      for (int k = 0; k < 3; ++k) mesh.vertices.positions.push_back(at + 0.1 * place(random));
      const auto v = static_cast<std::uint32_t>(3 * i);
      mesh.triangles.push_back({v, v + 1, v + 2});
    }
    const TriangleTree tree(mesh);
    std::size_t different = 0;
    for (int trial = 0; trial < 200; ++trial) {
      const Vec3 p = 1.5 * place(random);
      double best = std::numeric_limits<double>::infinity();
      for (const Triangle& t : mesh.triangles)
        best = std::min(best, squared_distance_to_triangle(p, mesh.vertices.positions[t[0]],
                                                           mesh.vertices.positions[t[1]],
                                                           mesh.vertices.positions[t[2]]));
      different += tree.squared_distance(p) != best;
    }
    CHECK(different == 0);
  }
  CHECK(std::isinf(TriangleTree(TriangleMesh{}).squared_distance({})));
}

TEST_CASE("AMeshIsIdenticalToItselfAndTheSameSurfaceInAnyOrder") {
  const TriangleMesh mesh = shape_mesh(Shape::kTorus, 40);
  const MeshComparison self = by_vertices(mesh, mesh);
  CHECK(self.identical);
  CHECK(self.same_surface);
  CHECK(self.a_to_b.max == 0.0);
  TriangleMesh other = mesh;
  std::reverse(other.vertices.positions.begin(), other.vertices.positions.end());
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (Triangle& t : other.triangles) t = {last - t[1], last - t[2], last - t[0]};
  const MeshComparison reordered = by_vertices(mesh, other);
  CHECK_FALSE(reordered.identical);
  CHECK(reordered.same_surface);
  std::swap(other.triangles[7][0], other.triangles[7][1]);
  CHECK_FALSE(by_vertices(mesh, other).same_surface);
}

TEST_CASE("AMovedPlaneIsAsFarAsItWasMoved") {
  const TriangleMesh mesh = shape_mesh(Shape::kPlane, 20);
  TriangleMesh moved = mesh;
  for (Vec3& p : moved.vertices.positions) p.z += 0.25;
  const MeshComparison result = by_vertices(mesh, moved);
  CHECK_FALSE(result.same_surface);
  for (const DistanceSummary& side : {result.a_to_b, result.b_to_a}) {
    CHECK(side.mean == Approx(0.25));
    CHECK(side.rms == Approx(0.25));
    CHECK(side.percentile_95 == Approx(0.25));
    CHECK(side.max == Approx(0.25));
    CHECK(side.measured == mesh.vertices.size());
    CHECK_FALSE(side.sampled());
  }
}

TEST_CASE("DistancesAreTakenToTheSurfaceAndInBothDirections") {
  // A coarse and a fine sphere: the chord's sagitta, not the distance between vertices.
  const MeshComparison result =
      by_vertices(shape_mesh(Shape::kSphere, 200), shape_mesh(Shape::kSphere, 50));
  CHECK(result.a_to_b.max < 0.006);
  CHECK(result.a_to_b.max > 0.001);
  // A part of a mesh lies on it, but not the other way round.
  const TriangleMesh whole = shape_mesh(Shape::kDoubleWall, 10);
  TriangleMesh part = whole;
  part.triangles.resize(part.triangles.size() / 2);
  part.vertices.positions.resize(part.vertices.positions.size() / 2);
  const MeshComparison sides = by_vertices(part, whole);
  CHECK(sides.a_to_b.max == 0.0);
  CHECK(sides.b_to_a.max > 0.0);
}

TEST_CASE("SamplesAreSpreadByArea") {
  // A large and a small square; 1 of 10 points belongs on the small one.
  TriangleMesh mesh;
  for (const double side : {3.0, 1.0}) {
    const double at = side == 3.0 ? 0.0 : 10.0;
    for (const Vec3 p : {Vec3{at, 0, 0}, {at + side, 0, 0}, {at + side, side, 0}, {at, side, 0}})
      mesh.vertices.positions.push_back(p);
  }
  mesh.triangles = {{0, 1, 2}, {1, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  const AreaSamples samples = sample_by_area(mesh, 1000);
  REQUIRE(samples.positions.size() == 1000);
  Vec3 sum;
  int small = 0;
  for (std::size_t i = 0; i < 1000; ++i) {
    const Vec3 p = samples.positions[i];
    CHECK(samples.normals[i] == Vec3{0, 0, 1});
    if (p.x >= 10.0)
      ++small;
    else
      sum = sum + p;
  }
  CHECK(small == 100);
  CHECK(norm(sum / 900.0 - Vec3{1.5, 1.5, 0.0}) < 0.02);
  CHECK(sample_by_area(TriangleMesh{}, 10).positions.empty());
  mesh.triangles = {{1, 1, 2}};
  CHECK(sample_by_area(mesh, 10).positions.empty());
}

TEST_CASE("PrecisionAndRecallTellWhatIsInventedAndWhatIsMissing") {
  // The plane's square, and the same moved by a quarter of its side: three quarters in common.
  const TriangleMesh truth = shape_mesh(Shape::kPlane, 20);
  const double side = truth.vertices.bounds().extent().x;
  TriangleMesh moved = truth;
  for (Vec3& p : moved.vertices.positions) p.x += 0.25 * side;
  CompareOptions options;
  options.area_samples = 20'000;
  options.within = {1e-6 * side, 0.125 * side, side};
  const SurfaceAgreement found = compare_meshes(moved, truth, options).surface;
  REQUIRE(found.within.size() == 3);
  for (int i = 0; i < 3; ++i) {
    const double expected = std::array{0.75, 0.875, 1.0}[static_cast<std::size_t>(i)];
    CHECK(found.within[i].precision == Approx(expected).margin(0.01));
    CHECK(found.within[i].recall == Approx(expected).margin(0.01));
    CHECK(found.within[i].f_score == Approx(expected).margin(0.01));
  }
  CHECK(found.hausdorff == Approx(0.25 * side));
  CHECK(found.a_to_b.median < 1e-12 * side);
  CHECK(found.a_to_b.mean == Approx(side / 32.0).epsilon(0.02));
  CHECK(found.normal_angle < 1e-3);
  CHECK(found.opposite == 0.0);
  // Half of the recall, all of the precision.
  TriangleMesh part = truth;
  part.triangles.resize(part.triangles.size() / 2);
  const SurfaceAgreement half = compare_meshes(part, truth, options).surface;
  CHECK(half.within[0].precision == 1.0);
  CHECK(half.within[0].recall == Approx(0.5).margin(0.01));
  CHECK(half.within[0].f_score == Approx(2.0 / 3.0).margin(0.01));
}

TEST_CASE("NormalsAreComparedWithAndWithoutTheirSides") {
  const TriangleMesh mesh = shape_mesh(Shape::kPlane, 10);
  TriangleMesh tilted = mesh, turned = mesh;
  for (Vec3& p : tilted.vertices.positions) p.z += p.x * std::tan(std::numbers::pi / 6.0);
  for (Triangle& t : turned.triangles) std::swap(t[0], t[1]);
  CompareOptions options;
  options.area_samples = 2000;
  const SurfaceAgreement tilt = compare_meshes(mesh, tilted, options).surface;
  CHECK(tilt.normal_angle == Approx(30.0));
  CHECK(tilt.opposite == 0.0);
  const SurfaceAgreement turn = compare_meshes(mesh, turned, options).surface;
  CHECK(turn.normal_angle < 1e-3);
  CHECK(turn.opposite == 1.0);
}

TEST_CASE("ErrorsOfVerticesAreTheirDistancesToTheOtherSurface") {
  const TriangleMesh mesh = shape_mesh(Shape::kPlane, 10);
  TriangleMesh bent = mesh;
  bent.vertices.positions[7].z += 0.5;
  bent.vertices.positions[8].x = std::nan("");
  const std::vector<double> errors = vertex_distances(bent, mesh);
  REQUIRE(errors.size() == mesh.vertices.size());
  CHECK(errors[7] == Approx(0.5));
  CHECK(std::isnan(errors[8]));
  CHECK(errors[0] == 0.0);
}

TEST_CASE("LargeComparisonsAreSampledEvenlyAndSaySo") {
  const TriangleMesh mesh = shape_mesh(Shape::kSphere, 100);
  TriangleMesh grown = mesh;
  for (Vec3& p : grown.vertices.positions) p = 1.5 * p;
  CompareOptions options;
  options.max_samples = 500;
  const MeshComparison sampled = by_vertices(mesh, grown, options);
  CHECK(sampled.a_to_b.measured == 500);
  CHECK(sampled.a_to_b.sampled());
  CHECK(sampled.a_to_b.points == mesh.vertices.size());
  CHECK(sampled.a_to_b.mean == Approx(by_vertices(mesh, grown).a_to_b.mean).epsilon(0.01));
}

TEST_CASE("EmptyMeshesCloudsAndBrokenVerticesAreComparedAsFarAsTheyCanBe") {
  const TriangleMesh mesh = shape_mesh(Shape::kSphere, 20);
  const MeshComparison nothing = by_vertices(mesh, TriangleMesh{});
  CHECK_FALSE(nothing.same_surface);
  CHECK(nothing.a_to_b.measured == 0);
  CHECK(nothing.b_to_a.measured == 0);
  TriangleMesh cloud = mesh, other = mesh;
  cloud.triangles.clear();
  other.triangles.clear();
  other.vertices.positions[3].x += 0.5;
  CHECK(by_vertices(cloud, cloud).identical);
  CHECK_FALSE(by_vertices(cloud, other).same_surface);
  CHECK(by_vertices(mesh, cloud).a_to_b.max == 0.0);
  TriangleMesh broken = mesh;
  broken.vertices.positions[5].y = std::nan("");
  const MeshComparison partly = by_vertices(broken, mesh);
  CHECK(partly.a_to_b.measured == mesh.vertices.size() - 1);
  CHECK(partly.b_to_a.measured == mesh.vertices.size());
  CHECK(std::isfinite(partly.b_to_a.max));
}

TEST_CASE("VerticesThatNoTriangleUsesAreNoPartOfASurface") {
  const TriangleMesh plane = shape_mesh(Shape::kPlane, 16);
  TriangleMesh loose = plane;
  loose.vertices.append(loose.vertices, 0);
  loose.vertices.positions.back() = {0.5, 0.5, 7.0};
  for (const MeshComparison& found :
       {compare_meshes(loose, plane), compare_meshes(plane, loose), compare_meshes(loose, loose)}) {
    CHECK(found.a_to_b.points == plane.vertices.size());
    CHECK(found.b_to_a.points == plane.vertices.size());
    CHECK(found.a_to_b.max == 0.0);
    CHECK(found.b_to_a.max == 0.0);
    CHECK(found.surface.hausdorff < 1e-12);
  }
  CHECK(distances_to_cloud(loose, plane.vertices).mesh_to_cloud.max == 0.0);
  // Vertices alone are a cloud, and count.
  loose.triangles.clear();
  CHECK(compare_meshes(loose, plane).a_to_b.max == Approx(7.0));
}

TEST_CASE("DistancesToACloudTellWhatTheMeshMissed") {
  const PointCloud cloud = synthetic(Shape::kSphere, 5000);
  const CloudDistances distances = distances_to_cloud(shape_mesh(Shape::kSphere, 100), cloud);
  CHECK(distances.cloud_to_mesh.max < 0.002);
  CHECK(distances.mesh_to_cloud.max < 0.06);
  CHECK(distances.mesh_to_cloud.max > 0.02);
  CHECK(distances.cloud_to_mesh.measured == 5000);
}

TEST_CASE("CloudFactsCountWhatIsWrongWithACloud") {
  PointCloud cloud = synthetic(Shape::kTorus, 4000);
  const Box bounds = cloud.bounds();
  for (const std::size_t i : {0u, 10u, 20u}) cloud.append(PointCloud(cloud), i);
  cloud.normals[1] = {};
  cloud.normals[2].x = std::nan("");
  cloud.append(PointCloud(cloud), 5);
  cloud.positions.back().z = std::numeric_limits<double>::infinity();
  MemorySource source(cloud);
  const CloudFacts facts = cloud_facts(source);
  CHECK(facts.points == 4004);
  CHECK(facts.bounds == bounds);
  CHECK(facts.has_normals);
  CHECK(facts.not_finite == 1);
  CHECK(facts.zero_normals == 1);
  CHECK(facts.normals_not_finite == 1);
  CHECK(facts.duplicates == 3);
  const double nominal = std::sqrt(surface_area(Shape::kTorus) / 4000);
  REQUIRE(facts.spacing.has_value());
  CHECK(*facts.spacing == Approx(nominal).epsilon(0.15));
  CHECK(*facts.spacing_of_six == Approx(nominal).epsilon(0.2));
}

TEST_CASE("CloudFactsOfNothingAndOfOnePointHaveNoSpacing") {
  for (const std::size_t points : {0u, 1u, 50u}) {
    PointCloud cloud;
    cloud.positions.assign(points, Vec3{1, 2, 3});
    MemorySource source(cloud);
    const CloudFacts facts = cloud_facts(source);
    CHECK(facts.points == points);
    CHECK(facts.duplicates == (points > 0 ? points - 1 : 0));
    CHECK_FALSE(facts.spacing.has_value());
    CHECK(facts.bounds.empty() == (points == 0));
  }
}

TEST_CASE("LargeCloudsAreMeasuredInCubesOnASecondReading") {
  SyntheticOptions options;
  options.points = 200'000;
  CloudFactsOptions limits;
  limits.whole_spacing_points = 150'000;
  limits.duplicate_points = 180'000;
  SyntheticCloud first(options), second(options), alone(options);
  const CloudFacts facts = cloud_facts(first, &second, limits);
  REQUIRE(facts.spacing.has_value());
  CHECK(*facts.spacing == Approx(spacing(options)).epsilon(0.1));
  CHECK_FALSE(facts.duplicates.has_value());
  CHECK_FALSE(cloud_facts(alone, nullptr, limits).spacing.has_value());
}

}  // namespace orbweave
