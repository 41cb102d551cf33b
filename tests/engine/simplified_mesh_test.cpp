// One simplified mesh: what its users rely on.
#include "engine/levels/simplified_mesh.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/geometry/triangle_tree.h"
#include "engine/levels/chosen_vertices.h"
#include "engine/levels/tileset_work.h"
#include "engine/validation/mesh_facts.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "tests/support/data.h"
#include "tests/support/meshes.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

using Kind = SimplifyTarget::Kind;
using test::ScratchDirectory;

constexpr std::uint64_t kLeafTriangles = 700;

/// Closed, with a handle, and bumpy enough for errors to matter.
TriangleMesh bumpy_torus(std::size_t vertices = 6000) {
  return test::moved(test::torus_mesh(vertices), [](Vec3 p) {
    return (8.0 + 0.2 * std::sin(9.0 * p.x) * std::cos(11.0 * p.y)) * p;
  });
}

/// Closed, with every vertex moved by a third of the spacing, as a noisy scan has it.
TriangleMesh rough_torus() {
  TriangleMesh mesh = test::torus_mesh(5000);
  std::uint64_t state = 1;
  const auto noise = [&] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return 0.02 * (static_cast<double>(state >> 40) / (1 << 24) - 0.5);
  };
  for (Vec3& p : mesh.vertices.positions) p = p + Vec3{noise(), noise(), noise()};
  return mesh;
}

TriangleMesh open_sheet() {
  TriangleMesh mesh = test::grid_mesh(70, 50, false, [](double u, double v) {
    return Vec3{30.0 * u, 20.0 * v, std::sin(8.0 * u) * std::cos(6.0 * v)};
  });
  test::cut(mesh, [](Vec3 p) { return norm(p - Vec3{12.0, 9.0, p.z}) < 3.0; });
  return mesh;
}

struct Simplified {
  SimplifiedFacts facts;
  TriangleMesh mesh;
  std::string bytes;
};

Simplified simplify(const TriangleMesh& mesh, SimplifyTarget target, LevelOptions levels = {}) {
  const ScratchDirectory scratch;
  write_mesh(scratch / "mesh.ply", mesh);
  SimplifyOptions options;
  options.levels = levels;
  options.levels.leaf_triangles = kLeafTriangles;
  options.levels.directory = scratch / "work";
  options.target = target;
  options.written = [](const Box&) { return MeshWriterOptions{}; };
  const TilesetWork work(options.levels.directory);
  const StopToken stop;
  Simplified result;
  result.facts = write_simplified(scratch / "mesh.ply", scratch / "small.ply", options, {}, stop);
  result.mesh = read_mesh(scratch / "small.ply");
  result.bytes = test::file_text(scratch / "small.ply");
  CHECK(result.facts.vertices == result.mesh.vertices.size());
  CHECK(result.facts.triangles == result.mesh.triangles.size());
  return result;
}

/// Places of triangles, each turned to begin with its least corner.
std::multiset<std::vector<double>> places_of(const TriangleMesh& mesh) {
  std::multiset<std::vector<double>> places;
  for (const Triangle& t : mesh.triangles) {
    std::vector<std::vector<double>> corners;
    for (const std::uint32_t corner : t) {
      const Vec3 p = mesh.vertices.positions[corner];
      corners.push_back({p.x, p.y, p.z});
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    std::vector<double> all;
    for (const auto& corner : corners) all.insert(all.end(), corner.begin(), corner.end());
    places.insert(all);
  }
  return places;
}

}  // namespace

TEST_CASE("SimplifiedMeshHasTheTrianglesThatAreAskedFor") {
  const TriangleMesh mesh = bumpy_torus();
  for (const std::uint64_t most : {11'000u, 6'001u, 2'500u, 700u, 200u}) {
    INFO(most);
    const Simplified small = simplify(mesh, {Kind::kTriangles, static_cast<double>(most)});
    CHECK(small.facts.triangles <= most);
    CHECK(small.facts.triangles >= most - most / 50);
    CHECK(small.facts.most_triangles == most);
  }
  const Simplified quarter = simplify(mesh, {Kind::kRatio, 0.25});
  CHECK(quarter.facts.triangles <= mesh.triangles.size() / 4);
  CHECK(quarter.facts.triangles_read == mesh.triangles.size());
}

TEST_CASE("SimplifiedMeshIsTheSameAtAnyScale") {
  const TriangleMesh mesh = bumpy_torus();
  const Simplified plain = simplify(mesh, {Kind::kRatio, 0.2});
  for (const int exponent : {-200, -150, -30, 30, 140, 200}) {
    INFO(exponent);
    const double scale = std::ldexp(1.0, exponent);
    const Simplified scaled =
        simplify(test::moved(mesh, [&](Vec3 p) { return scale * p; }), {Kind::kRatio, 0.2});
    CHECK(scaled.mesh.triangles == plain.mesh.triangles);
    CHECK(scaled.facts.error == scale * plain.facts.error);
  }
}

TEST_CASE("SimplifiedMeshOfAClosedManifoldIsOneOfTheSameGenus") {
  const TriangleMesh mesh = bumpy_torus();
  const MeshFacts before = mesh_facts(mesh);
  REQUIRE(before.euler_characteristic == 0);
  for (const SimplifyTarget target :
       {SimplifyTarget{Kind::kRatio, 0.7}, SimplifyTarget{Kind::kRatio, 0.2},
        SimplifyTarget{Kind::kTriangles, 300}, SimplifyTarget{Kind::kTriangles, 60},
        SimplifyTarget{Kind::kError, 0.02}, SimplifyTarget{Kind::kError, 0.5}}) {
    INFO(simplify_target_text(target));
    const Simplified small = simplify(mesh, target);
    CHECK(validate_mesh(small.mesh).empty());
    const MeshFacts facts = mesh_facts(small.mesh);
    CHECK(facts.boundary_edges == 0);
    CHECK(facts.nonmanifold_edges == 0);
    CHECK(facts.nonmanifold_vertices == 0);
    CHECK(facts.components == 1);
    CHECK(facts.euler_characteristic == 0);
    CHECK(facts.triangles < before.triangles);
  }
}

TEST_CASE("SimplifiedMeshOfANoisyManifoldIsAManifold") {
  const TriangleMesh mesh = rough_torus();
  REQUIRE(mesh_facts(mesh).watertight);
  for (const double ratio : {0.6, 0.3, 0.1, 0.03, 0.01}) {
    INFO(ratio);
    const Simplified small = simplify(mesh, {Kind::kRatio, ratio});
    CHECK(validate_mesh(small.mesh).empty());
    const MeshFacts facts = mesh_facts(small.mesh);
    CHECK(facts.watertight);
    CHECK(facts.nonmanifold_vertices == 0);
    CHECK(facts.euler_characteristic == 0);
  }
}

TEST_CASE("SimplifiedMeshStaysWithinTheErrorThatItStates") {
  for (const TriangleMesh& mesh : {bumpy_torus(), open_sheet()}) {
    std::uint64_t fewer = mesh.triangles.size();
    for (const double error : {0.005, 0.05, 0.4}) {
      const Simplified small = simplify(mesh, {Kind::kError, error});
      CHECK(small.facts.error <= error);
      CHECK(small.facts.triangles < fewer);
      fewer = small.facts.triangles;
      const TriangleTree tree(small.mesh);
      double farthest = 0.0;
      for (const Vec3& p : mesh.vertices.positions)
        farthest = std::max(farthest, std::sqrt(tree.squared_distance(p)));
      CHECK(farthest <= small.facts.error + 1e-9);
    }
  }
}

TEST_CASE("SimplifiedMeshHasVerticesOfTheMeshWithAllThatTheyCarry") {
  TriangleMesh mesh = bumpy_torus(3000);
  mesh.vertices.schema.has_normals = true;
  mesh.vertices.schema.normal_type = ScalarType::kFloat64;
  mesh.vertices.schema.attributes = {{"time", ScalarType::kFloat64}, {"red", ScalarType::kUint8}};
  std::map<std::vector<double>, std::uint8_t> red;
  std::map<std::vector<double>, double> time;
  for (std::size_t i = 0; i < mesh.vertices.positions.size(); ++i) {
    const Vec3 p = mesh.vertices.positions[i];
    mesh.vertices.normals.push_back(normalized(p));
    const double at = 1e9 + 1e-3 * static_cast<double>(i);
    const auto shade = static_cast<std::uint8_t>(i * 37);
    time[{p.x, p.y, p.z}] = at;
    red[{p.x, p.y, p.z}] = shade;
    const auto* bytes = reinterpret_cast<const std::byte*>(&at);
    mesh.vertices.attributes.insert(mesh.vertices.attributes.end(), bytes, bytes + sizeof at);
    mesh.vertices.attributes.push_back(static_cast<std::byte>(shade));
  }
  const Simplified small = simplify(mesh, {Kind::kRatio, 0.3});
  REQUIRE(small.mesh.vertices.schema == mesh.vertices.schema);
  for (std::size_t i = 0; i < small.mesh.vertices.size(); ++i) {
    const Vec3 p = small.mesh.vertices.positions[i];
    REQUIRE(time.count({p.x, p.y, p.z}) == 1);
    double at = 0.0;
    std::memcpy(&at, small.mesh.vertices.attributes.data() + 9 * i, sizeof at);
    CHECK(at == time[{p.x, p.y, p.z}]);
    CHECK(static_cast<std::uint8_t>(small.mesh.vertices.attributes[9 * i + 8]) ==
          red[{p.x, p.y, p.z}]);
    CHECK(norm(small.mesh.vertices.normals[i] - normalized(p)) < 1e-12);
  }
}

TEST_CASE("SimplifiedMeshIsTheSameForAnyThreadsAndMemory") {
  const TriangleMesh mesh = bumpy_torus();
  for (const SimplifyTarget target :
       {SimplifyTarget{Kind::kRatio, 0.4}, SimplifyTarget{Kind::kError, 0.05}}) {
    LevelOptions levels;
    const std::string first = simplify(mesh, target, levels).bytes;
    levels.threads = 3;
    CHECK((simplify(mesh, target, levels).bytes == first));
    levels.memory_bytes = std::uint64_t{64} << 20;
    CHECK((simplify(mesh, target, levels).bytes == first));
  }
}

TEST_CASE("SimplificationToAllTrianglesIsTheMesh") {
  for (const TriangleMesh& mesh : {open_sheet(), bumpy_torus(20'000)}) {
    for (const SimplifyTarget& target :
         {SimplifyTarget{Kind::kRatio, 1.0}, SimplifyTarget{Kind::kTriangles, 1e9}}) {
      const Simplified same = simplify(mesh, target);
      CHECK(same.facts.error == 0.0);
      CHECK(same.mesh.vertices.positions == mesh.vertices.positions);
      CHECK((places_of(same.mesh) == places_of(mesh)));
    }
  }
}

TEST_CASE("RimsOfASimplifiedMeshAreThoseOfTheMesh") {
  const TriangleMesh mesh = open_sheet();
  const MeshFacts before = mesh_facts(mesh);
  for (const double ratio : {0.5, 0.05}) {
    const Simplified small = simplify(mesh, {Kind::kRatio, ratio});
    const MeshFacts after = mesh_facts(small.mesh);
    CHECK(after.boundary_loops == before.boundary_loops);
    CHECK(after.boundary_edges < before.boundary_edges);
    CHECK(validate_mesh(small.mesh).empty());
  }
}

TEST_CASE("ChosenVerticesAreNumberedInTheirOrder") {
  constexpr std::uint64_t kVertices = 20'000;
  ChosenVertices chosen(kVertices);
  std::vector<std::uint64_t> expected;
  for (std::uint64_t i = 0; i < kVertices; i = i * 5 / 4 + 1) expected.push_back(i);
  for (std::uint64_t i = 9000; i < 9200; ++i) expected.push_back(i);
  std::sort(expected.begin(), expected.end());
  expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
  for (const std::uint64_t vertex : expected) chosen.choose(vertex);
  chosen.number();
  CHECK(chosen.count() == expected.size());
  for (std::uint64_t i = 0; i < expected.size(); ++i) CHECK(chosen.rank(expected[i]) == i);
  CHECK_FALSE(chosen.is_chosen(8998));
}

TEST_CASE("LimitsOfASimplificationAreReadAsTheyAreWritten") {
  for (const char* text : {"ratio=0.25", "triangles=1200", "error=0.001", "ratio=1"}) {
    const auto target = parse_simplify_target(text);
    REQUIRE(target);
    CHECK(simplify_target_text(*target) == text);
  }
  CHECK(parse_simplify_target(" { ratio = 0.5 } ")->value == 0.5);
  for (const char* text :
       {"", "0.5", "ratio", "ratio=", "ratio=0", "ratio=1.5", "ratio=-0.1", "ratio=nan",
        "ratio=0.5x", "triangles=0", "triangles=1.5", "triangles=1e300", "error=0", "error=inf",
        "error=-1", "points=5", "{ratio=0.5"})
    CHECK_FALSE(parse_simplify_target(text));
  CHECK(most_triangles({Kind::kRatio, 0.5}, 101) == 50);
  CHECK(most_triangles({Kind::kRatio, 1e-9}, 101) == 1);
  CHECK(most_triangles({Kind::kTriangles, 500}, 101) == 101);
}

}  // namespace orbweave
