#include "engine/normals/normals_from_faces.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "engine/geometry/point_tree.h"
#include "engine/synthetic/synthetic_cloud.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

TriangleMesh torus_mesh(std::uint32_t resolution) {
  SyntheticOptions options;
  options.shape = Shape::kTorus;
  return truth_mesh(options, resolution);
}

}  // namespace

TEST_CASE("FaceNormalsApproachTheExactNormals") {
  for (const std::uint32_t resolution : {60u, 240u}) {
    const TriangleMesh mesh = torus_mesh(resolution);
    const std::vector<Vec3> normals = normals_from_faces(mesh);
    double worst = 0.0;
    for (std::size_t v = 0; v < normals.size(); ++v) {
      worst = std::max(worst, norm(normals[v] - mesh.vertices.normals[v]));
      REQUIRE(norm(normals[v]) == Approx(1.0).epsilon(1e-14));
    }
    CHECK(worst < 10.0 / resolution);
  }
}

TEST_CASE("FacesAreWeightedByTheirArea") {
  TriangleMesh mesh;
  mesh.vertices.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};  // areas 2 and 1, normals z and x
  const std::vector<Vec3> normals = normals_from_faces(mesh);
  CHECK(norm(normals[0] - normalized(Vec3{1, 0, 2})) < 1e-15);
  CHECK(normals[1] == Vec3{0, 0, 1});
  CHECK(normals[3] == Vec3{1, 0, 0});
}

TEST_CASE("VerticesThatNoFaceUsesTakeTheNearestNormal") {
  TriangleMesh mesh;
  mesh.vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0},     {5, 0, 0},
                             {5, 1, 0}, {5, 0, 1}, {0.2, 0.2, 1}, {4.5, 0.2, 0.2}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const std::vector<Vec3> normals = normals_from_faces(mesh);
  CHECK(normals[6] == Vec3{0, 0, 1});
  CHECK(normals[7] == Vec3{1, 0, 0});
}

TEST_CASE("CancellingNormalsAndEquallyNearOnesAreDecidedByTheFirstVertex") {
  TriangleMesh mesh;
  // Vertex 0 has two faces back to back; 1 and 4 are equally near, 1 comes first.
  mesh.vertices.positions = {{0, 0, 0},  {1, 0, 0},  {0, 3, 0}, {0, 3, 3}, {-1, 0, 0},
                             {-1, 3, 0}, {-1, 0, 3}, {1, 3, 1}, {1, 3, -1}};
  mesh.triangles = {{0, 2, 3}, {0, 3, 2}, {1, 7, 8}, {4, 5, 6}};
  const std::vector<Vec3> normals = normals_from_faces(mesh);
  CHECK(normals[1] != normals[4]);
  CHECK(normals[0] == normals[1]);
}

TEST_CASE("UtmSizedCoordinatesLoseNothing") {
  TriangleMesh mesh = torus_mesh(100);
  // Coordinates that both places hold exactly.
  for (Vec3& p : mesh.vertices.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] = std::round(p[axis] * 0x1p20) * 0x1p-20;
  const std::vector<Vec3> here = normals_from_faces(mesh);
  for (Vec3& p : mesh.vertices.positions) p = p + Vec3{691000.0, 5334000.0, 512.0};
  CHECK(normals_from_faces(mesh) == here);
}

TEST_CASE("MeshesWithoutAreaGetZeroNormalsAndWrongIndicesAreBadInput") {
  TriangleMesh mesh;
  CHECK(normals_from_faces(mesh).empty());
  mesh.vertices.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}};
  for (const Vec3& n : normals_from_faces(mesh)) CHECK(n == Vec3{});
  mesh.triangles = {{0, 1, 3}};
  CHECK_THROWS_AS(normals_from_faces(mesh), Error);
  mesh.triangles = {{0, 1, 2}};
  mesh.vertices.positions[2] = {std::nan(""), 0, 0};
  CHECK(normals_from_faces(mesh).size() == 3);
}

TEST_CASE("EveryVertexOfTheStanfordBunnyGetsAUnitNormal") {
  const auto path = test::data_path("stanford/bun_zipper.ply");
  if (test::skipped_without(path)) return;
  const TriangleMesh mesh = read_mesh(path);
  REQUIRE(mesh.vertices.size() == 35947);
  for (const Vec3& n : normals_from_faces(mesh)) REQUIRE(std::abs(norm(n) - 1.0) < 1e-14);
}

TEST_CASE("PointTreeFindsTheSameAsComparingWithAllAndBreaksTiesByIndex") {
  std::mt19937_64 random(11);
  std::vector<Vec3> points;
  // A coarse grid with repeats: ties are everywhere.
  for (int i = 0; i < 600; ++i)
    points.push_back({double(random() % 6), double(random() % 6), double(random() % 6)});
  const PointTree tree(points);
  std::vector<Neighbor> found;
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 query{double(random() % 12) / 2, double(random() % 12) / 2, double(random() % 7)};
    std::vector<Neighbor> all;
    for (std::uint32_t i = 0; i < points.size(); ++i)
      all.push_back({squared_norm(points[i] - query), i});
    std::sort(all.begin(), all.end(), [](const Neighbor& a, const Neighbor& b) {
      return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance
                                                      : a.index < b.index;
    });
    tree.nearest(query, 25, found);
    CHECK(std::equal(found.begin(), found.end(), all.begin(), all.begin() + 25));
  }
  tree.nearest({}, 1000, found);
  CHECK(found.size() == points.size());
}

}  // namespace orbweave
