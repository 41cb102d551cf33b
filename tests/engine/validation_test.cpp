#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include <catch2/catch.hpp>

#include "engine/synthetic/synthetic_cloud.h"
#include "engine/validation/mesh_facts.h"
#include "engine/validation/odd_scans.h"
#include "io/error.h"
#include "io/meshes/mesh_checksum.h"
#include "io/stop_token.h"

namespace orbweave {
namespace {

TriangleMesh mesh_of(std::vector<Vec3> positions, std::vector<Triangle> triangles) {
  TriangleMesh mesh;
  mesh.vertices.positions = std::move(positions);
  mesh.triangles = std::move(triangles);
  return mesh;
}

TriangleMesh shape_mesh(Shape shape, std::uint32_t resolution) {
  SyntheticOptions options;
  options.shape = shape;
  return truth_mesh(options, resolution);
}

/// Grid of 2 x columns x rows triangles over a square, cell (i, j) left out where `leave_out`.
template <class LeaveOut>
TriangleMesh grid(std::uint32_t columns, std::uint32_t rows, LeaveOut leave_out) {
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= rows; ++j)
    for (std::uint32_t i = 0; i <= columns; ++i)
      mesh.vertices.positions.push_back({double(i), double(j), 0.0});
  for (std::uint32_t j = 0; j < rows; ++j)
    for (std::uint32_t i = 0; i < columns; ++i) {
      if (leave_out(i, j)) continue;
      const std::uint32_t a = j * (columns + 1) + i, b = a + 1, d = a + columns + 1, c = d + 1;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

PlacedScan placed(Vec3 corner, double side, std::uint64_t points = 10000, Vec3 origin = {}) {
  return {{corner, corner + Vec3{side, side, 0.3 * side}}, points, origin};
}

using Scans = std::vector<PlacedScan>;

TEST_CASE("ScansThatLieBesideEachOtherAreNotOdd") {
  CHECK(odd_scans({}).empty());
  CHECK(odd_scans(Scans{placed({}, 1)}).empty());
  // Tiles, a sliver at their border, a close look at a detail, two objects in one hall.
  Scans tiles;
  for (int i = 0; i < 9; ++i)
    tiles.push_back(placed({500.0 * (i % 3), 500.0 * (i / 3), 0}, 500, 4'000'000));
  CHECK(odd_scans(tiles).empty());
  tiles.push_back({{{1500, 0, 0}, {1500.5, 1, 0.1}}, 200, {}});
  CHECK(odd_scans(tiles).empty());
  CHECK(odd_scans(Scans{placed({}, 30, 10'000'000), placed({3, 3, 1}, 0.2, 1'000'000)}).empty());
  CHECK(odd_scans(Scans{placed({100, 20, 1}, 2), placed({130, 50, 1}, 2)}).empty());
}

TEST_CASE("ScansInAnotherUnitAreOdd") {
  const Vec3 place{637000, 4850100, 130};
  const Scans feet{placed(place, 30), placed(place + Vec3{20, 0, 0}, 30),
                   placed((1 / 0.3048) * place, 100), placed(place + Vec3{0, 20, 0}, 30)};
  const auto odd = odd_scans(feet);
  REQUIRE(odd.size() == 1);
  CHECK(odd[0].place == OddPlace::kApart);
  CHECK(odd[0].scans == std::vector<std::size_t>{2});
  CHECK(std::abs(odd[0].factor - 0.3048) < 1e-6);
  // About the place of its pose, too.
  const Vec3 origin{50, 80, 0};
  const auto posed = odd_scans(Scans{placed({1050, 80, 0}, 5), placed({1050, 85, 0}, 5),
                                     placed({100050, 80, 0}, 500, 10000, origin)});
  REQUIRE(posed.size() == 1);
  CHECK(std::abs(posed[0].factor - 0.01) < 1e-12);
}

TEST_CASE("ScansThatAreAThousandTimesAsLargeAreOdd") {
  for (const double size : {1.0, 1000.0}) {
    const double other = size == 1.0 ? 1000.0 : 1.0;
    const auto odd = odd_scans(Scans{placed({-size / 2, -size / 2, 0}, size),
                                     placed({-size / 3, -size / 2, 0}, size),
                                     placed({-other / 2, -other / 2, 0}, other)});
    REQUIRE(odd.size() == 1);
    CHECK(odd[0].place == (size == 1.0 ? OddPlace::kLarger : OddPlace::kSmaller));
    CHECK(odd[0].scans == std::vector<std::size_t>{2});
  }
}

TEST_CASE("ScansWithAnotherOriginAreOddInAnyOrder") {
  const Vec3 place{637000, 4850100, 130};
  Scans scans{placed({0, 0, 0}, 30), placed(place, 30), placed(place + Vec3{50, 0, 0}, 30),
              placed({10, 0, 0}, 30), placed(place + Vec3{0, 70, 0}, 30)};
  for (int turn = 0; turn < 5; ++turn) {
    const auto odd = odd_scans(scans);
    REQUIRE(odd.size() == 1);
    REQUIRE(odd[0].scans.size() == 2);
    CHECK(odd[0].factor == 0.0);
    for (const std::size_t scan : odd[0].scans) CHECK(scans[scan].bounds.max.x < 100);
    std::rotate(scans.begin(), scans.begin() + 1, scans.end());
  }
}

}  // namespace

TEST_CASE("ClosedShapesAreWatertightWithTheirEulerCharacteristic") {
  for (const auto& [shape, chi] : {std::pair{Shape::kSphere, 2},
                                   {Shape::kTorus, 0},
                                   {Shape::kBumpyTorus, 0},
                                   {Shape::kCube, 2},
                                   {Shape::kTwoComponents, 2},
                                   {Shape::kGenusThree, -4}}) {
    const TriangleMesh mesh = shape_mesh(shape, 30);
    const MeshFacts facts = mesh_facts(mesh);
    INFO(name_of(shape));
    CHECK(validate_mesh(mesh).empty());
    CHECK(facts.watertight);
    CHECK(facts.euler_characteristic == chi);
    CHECK(facts.triangles == 2 * facts.vertices - 2 * chi);
    CHECK(facts.components == (shape == Shape::kTwoComponents ? 2 : 1));
    CHECK(facts.boundary_edges + facts.boundary_loops + facts.nonmanifold_edges +
              facts.nonmanifold_vertices + facts.inconsistent_edges + facts.degenerate_triangles +
              facts.duplicate_triangles + facts.unreferenced_vertices ==
          0);
  }
}

TEST_CASE("OpenSheetsHaveOneLoopEachAndAreNotWatertight") {
  const MeshFacts facts = mesh_facts(shape_mesh(Shape::kDoubleWall, 10));
  CHECK(facts.components == 2);
  CHECK(facts.boundary_loops == 2);
  CHECK(facts.boundary_edges == 80);
  CHECK(facts.euler_characteristic == 2);
  CHECK(facts.area == Approx(2.0));
  CHECK_FALSE(facts.watertight);
}

TEST_CASE("HolesThatTouchInAVertexAreSeparateLoops") {
  const auto facts = mesh_facts(
      grid(6, 6, [](auto i, auto j) { return (i == 2 && j == 2) || (i == 3 && j == 3); }));
  CHECK(facts.boundary_loops == 3);  // the border and the two holes
  CHECK(facts.boundary_edges == 24 + 8);
  CHECK(facts.nonmanifold_vertices == 1);
  CHECK(facts.nonmanifold_edges == 0);
  CHECK(facts.components == 1);
  // Two cells side by side are one hole.
  const auto joined =
      mesh_facts(grid(6, 6, [](auto i, auto j) { return (i == 2 || i == 3) && j == 2; }));
  CHECK(joined.boundary_loops == 2);
  CHECK(joined.nonmanifold_vertices == 0);
}

TEST_CASE("TwoTrianglesThatShareAVertexAreTwoComponentsAndTwoFans") {
  const auto facts = mesh_facts(
      mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}));
  CHECK(facts.components == 2);
  CHECK(facts.boundary_loops == 2);
  CHECK(facts.nonmanifold_vertices == 1);
}

TEST_CASE("EveryDefectIsCountedAndReported") {
  const std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0},  {0, 1, 0},
                                    {0, 0, 1}, {0, -1, 0}, {5, 5, 5}};
  SECTION("three triangles at an edge") {
    const auto mesh = mesh_of(points, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
    const MeshFacts facts = mesh_facts(mesh);
    CHECK(facts.nonmanifold_edges == 1);
    CHECK(facts.inconsistent_edges == 1);
    CHECK(facts.nonmanifold_vertices == 2);
    CHECK(facts.unreferenced_vertices == 1);
    CHECK(facts.components == 1);
    CHECK(validate_mesh(mesh).size() == 2);
  }
  SECTION("a flipped neighbour") {
    const auto mesh = mesh_of(points, {{0, 1, 2}, {0, 1, 4}});
    CHECK(mesh_facts(mesh).inconsistent_edges == 1);
    CHECK(mesh_facts(mesh).boundary_loops == 1);
    CHECK(validate_mesh(mesh).size() == 1);
  }
  SECTION("the same triangle again, rotated and flipped") {
    const auto rotated = mesh_of(points, {{0, 1, 2}, {1, 2, 0}});
    CHECK(mesh_facts(rotated).duplicate_triangles == 1);
    CHECK(mesh_facts(rotated).inconsistent_edges == 3);
    CHECK(validate_mesh(rotated).size() == 2);
    const auto flipped = mesh_of(points, {{0, 1, 2}, {0, 2, 1}});
    CHECK(mesh_facts(flipped).duplicate_triangles == 1);
    CHECK_FALSE(mesh_facts(flipped).watertight);
    CHECK(validate_mesh(flipped).size() == 1);
  }
  SECTION("a degenerate triangle") {
    const auto mesh = mesh_of(points, {{0, 1, 2}, {3, 3, 4}});
    const MeshFacts facts = mesh_facts(mesh);
    CHECK(facts.degenerate_triangles == 1);
    CHECK(facts.boundary_edges == 3);
    CHECK(facts.components == 1);
    CHECK(facts.euler_characteristic == 1);
    CHECK(validate_mesh(mesh).size() == 1);
  }
  SECTION("an index outside") {
    const auto mesh = mesh_of(points, {{0, 1, 6}});
    CHECK_THROWS_AS(mesh_facts(mesh), Error);
    CHECK(validate_mesh(mesh).size() == 1);
  }
  SECTION("a vertex that is not finite, and a wrong number of hole ids") {
    auto mesh = mesh_of(points, {{0, 1, 2}});
    mesh.vertices.positions[1].y = std::nan("");
    mesh.hole = {0, 1};
    CHECK(validate_mesh(mesh).size() == 2);
  }
}

TEST_CASE("AMeshWithACornerThatIsNotFiniteIsNotWatertight") {
  auto mesh = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                      {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}});
  mesh.vertices.positions.push_back({std::nan(""), 0.0, 0.0});  // of no triangle
  CHECK(mesh_facts(mesh).watertight);
  mesh.vertices.positions[3].z = std::nan("");
  const MeshFacts facts = mesh_facts(mesh);
  CHECK_FALSE(facts.watertight);
  CHECK(facts.boundary_edges == 0);
  CHECK(facts.area == 0.5);  // of the triangle that is left
}

TEST_CASE("AnEmptyMeshHasNoFactsAndIsNotWatertight") {
  const MeshFacts facts = mesh_facts(TriangleMesh{});
  CHECK(facts.vertices + facts.triangles + facts.components + facts.boundary_loops == 0);
  CHECK_FALSE(facts.watertight);
  CHECK(facts.checksum.size() == 16);
  CHECK(validate_mesh(TriangleMesh{}).empty());
}

TEST_CASE("FactsDoNotDependOnTheOrderOfTrianglesAndVertices") {
  TriangleMesh mesh = grid(20, 20, [](auto i, auto j) { return i * 7 + j * 5 % 11 == 24; });
  const MeshFacts before = mesh_facts(mesh);
  std::mt19937_64 random(7);
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  std::vector<Vec3> moved(order.size());
  for (std::size_t v = 0; v < order.size(); ++v) moved[order[v]] = mesh.vertices.positions[v];
  mesh.vertices.positions = moved;
  for (Triangle& t : mesh.triangles) t = {order[t[1]], order[t[2]], order[t[0]]};
  for (std::size_t i = mesh.triangles.size(); i > 1; --i)
    std::swap(mesh.triangles[i - 1], mesh.triangles[random() % i]);
  const MeshFacts after = mesh_facts(mesh);
  CHECK(after.boundary_edges == before.boundary_edges);
  CHECK(after.boundary_loops == before.boundary_loops);
  CHECK(after.components == before.components);
  CHECK(after.nonmanifold_vertices == before.nonmanifold_vertices);
  CHECK(after.euler_characteristic == before.euler_characteristic);
  CHECK(after.area == Approx(before.area).epsilon(1e-14));
  CHECK(after.checksum != before.checksum);
}

TEST_CASE("ChecksumDependsOnTheSurfaceAlone") {
  const TriangleMesh mesh = shape_mesh(Shape::kSphere, 12);
  const std::string checksum = mesh_facts(mesh).checksum;
  SECTION("not on normals, attributes and stray vertices") {
    TriangleMesh other = mesh;
    other.vertices.schema.has_normals = false;
    other.vertices.normals.clear();
    other.vertices.positions.insert(other.vertices.positions.begin(), Vec3{9, 9, 9});
    for (Triangle& t : other.triangles) t = {t[0] + 1, t[1] + 1, t[2] + 1};
    CHECK(mesh_facts(other).checksum == checksum);
  }
  SECTION("not on the sign of zero") {
    TriangleMesh other = mesh;
    std::size_t zeros = 0;
    for (Vec3& p : other.vertices.positions)
      if (p.x == 0.0 && ++zeros > 0) p.x = -p.x;
    CHECK(zeros > 0);
    CHECK(mesh_facts(other).checksum == checksum);
  }
  SECTION("on the last bit of a coordinate and on orientation") {
    TriangleMesh other = mesh;
    other.vertices.positions[5].y = std::nextafter(other.vertices.positions[5].y, 2.0);
    CHECK(mesh_facts(other).checksum != checksum);
    other = mesh;
    std::swap(other.triangles[3][0], other.triangles[3][1]);
    CHECK(mesh_facts(other).checksum != checksum);
  }
  SECTION("not on the parts that it is made of, nor on their order") {
    MeshChecksum whole, part;
    for (std::uint64_t t = mesh.triangles.size(); t-- > 0;) {
      const Triangle64 wide{mesh.triangles[t][0], mesh.triangles[t][1], mesh.triangles[t][2]};
      (t % 2 == 0 ? whole : part).add_triangles({&wide, 1}, t);
    }
    const std::span<const Vec3> positions = mesh.vertices.positions;
    part.add_vertices(positions.subspan(7), 7);
    whole.add_vertices(positions.first(7), 0);
    const auto sent = MeshChecksum::from_state(part.state());
    REQUIRE(sent);
    whole.add(*sent);
    CHECK(whole.hex() == checksum);
    CHECK_FALSE(MeshChecksum::from_state("12").has_value());
    CHECK_FALSE(MeshChecksum::from_state(std::string(64, 'x')).has_value());
  }
  SECTION("on the order of rows") {
    TriangleMesh other = mesh;
    std::swap(other.triangles[3], other.triangles[4]);
    CHECK(mesh_facts(other).checksum != checksum);
  }
}

TEST_CASE("ChecksumIsTheSameOnEveryMachine") {
  const auto mesh = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  CHECK(mesh_facts(mesh).checksum == "a03b81b9f37907c5");
}

TEST_CASE("ARequestToStopEndsTheCountOfFacts") {
  const TriangleMesh mesh = shape_mesh(Shape::kTorus, 200);
  const StopToken watched;
  CHECK(mesh_facts(mesh, &watched).checksum == mesh_facts(mesh).checksum);
  // Triangles are gone through for the table of edges, for areas and for the checksum.
  CHECK(watched.checks() > 4 * mesh.triangles.size() / kStopBlock);
  StopToken stopped;
  stopped.request();
  CHECK_THROWS_AS(mesh_facts(mesh, &stopped), Error);
}

}  // namespace orbweave
