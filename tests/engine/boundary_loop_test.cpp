#include "engine/holes/problem/boundary_loop.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/holes/hole_pass.h"
#include "engine/holes/loops/mesh_surface.h"
#include "io/error.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

using test::cut;

std::vector<BoundaryLoop> loops_of(const TriangleMesh& mesh) {
  const MeshSurface surface(mesh);
  const MeshComponents components = find_components(mesh, surface);
  MeshBoundary boundary = find_boundary(mesh, surface, components.of_triangle);
  return trace_loops(std::move(boundary.fans), boundary.vertices);
}

}  // namespace

TEST_CASE("AClosedMeshHasNoLoops") { REQUIRE(loops_of(test::torus_mesh(500)).empty()); }

TEST_CASE("LoopsRunAgainstTheTrianglesBesideThem") {
  const TriangleMesh mesh = test::square_mesh(4);
  const auto loops = loops_of(mesh);
  REQUIRE(loops.size() == 1);
  const auto& loop = loops[0].vertices;
  REQUIRE(loop.size() == 16);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::uint64_t a = loop[i], b = loop[(i + 1) % loop.size()];
    const bool with_a_triangle =
        std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
          return (t[0] == b && t[1] == a) || (t[1] == b && t[2] == a) || (t[2] == b && t[0] == a);
        });
    CHECK(with_a_triangle);
  }
  CHECK(loops[0].perimeter == Approx(4.0));
  CHECK(loops[0].radius == Approx(std::sqrt(0.5)));
  CHECK(loops[0].agreement() == Approx(-1.0));
}

TEST_CASE("HolesAgreeWithTheNormalsAroundThem") {
  TriangleMesh mesh = test::square_mesh(20);
  cut(mesh, [](Vec3 p) { return std::hypot(p.x - 0.5, p.y - 0.5) < 0.2; });
  const auto loops = loops_of(mesh);
  REQUIRE(loops.size() == 2);
  CHECK(loops[0].agreement() == Approx(-1.0));  // the border has vertex 0
  CHECK(loops[1].agreement() == Approx(1.0));
}

TEST_CASE("LoopsPassFromFanToFanAroundAVertex") {
  TriangleMesh mesh = test::square_mesh(10);
  cut(mesh, [](Vec3 p) {
    return (p.x > 0.3 && p.x < 0.5 && p.y > 0.3 && p.y < 0.5) ||
           (p.x > 0.5 && p.x < 0.7 && p.y > 0.5 && p.y < 0.7);
  });
  const auto loops = loops_of(mesh);
  REQUIRE(loops.size() == 3);
  for (const BoundaryLoop& loop : loops) {
    auto sorted = loop.vertices;
    std::sort(sorted.begin(), sorted.end());
    CHECK(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end());
  }
  CHECK(loops[1].vertices.size() == 8);
  CHECK(loops[2].vertices.size() == 8);
}

TEST_CASE("SheetsThatTouchKeepTheirLoopsApart") {
  // Two squares one above the other that share the vertex at the origin, both facing up.
  TriangleMesh mesh = test::square_mesh(2);
  const TriangleMesh other = test::moved(test::square_mesh(2), [](Vec3 p) {
    return Vec3{p.x, p.y, p.x + p.y};
  });
  mesh = test::joined(mesh, other);
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& vertex : t) vertex = vertex == 9 ? 0 : vertex;
  }
  const auto loops = loops_of(mesh);
  REQUIRE(loops.size() == 2);
  CHECK(loops[0].vertices.size() == 8);
  CHECK(loops[1].vertices.size() == 8);
  CHECK(loops[0].components.size() == 1);
}

TEST_CASE("LoopsDoNotDependOnTheOrderOfTriangles") {
  TriangleMesh mesh = test::torus_mesh(2000);
  cut(mesh, [](Vec3 p) { return std::abs(p.z) > 0.38; });
  TriangleMesh turned = mesh;
  std::reverse(turned.triangles.begin(), turned.triangles.end());
  const auto a = loops_of(mesh), b = loops_of(turned);
  REQUIRE(a.size() == 2 * 2);
  REQUIRE(a.size() == b.size());
  for (std::size_t l = 0; l < a.size(); ++l) CHECK(a[l].vertices == b[l].vertices);
}

TEST_CASE("LoopsThatRunIntoANonManifoldEdgeAreLeftOut") {
  TriangleMesh mesh = test::square_mesh(4);
  // A fin on an inner edge of the sheet.
  mesh.vertices.positions.push_back({0.5, 0.5, 1.0});
  const Triangle& t = mesh.triangles[10];
  mesh.triangles.push_back({t[0], t[1], static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  const auto loops = loops_of(mesh);
  REQUIRE(loops.size() == 1);
  CHECK(loops[0].vertices.size() == 16);
}

TEST_CASE("TracingEndsWhenItIsAskedTo") {
  const TriangleMesh mesh = test::square_mesh(4);
  const MeshSurface surface(mesh);
  const MeshComponents components = find_components(mesh, surface);
  MeshBoundary boundary = find_boundary(mesh, surface, components.of_triangle);
  StopToken stop;
  stop.request();
  try {
    plan_holes(std::move(boundary.fans), std::move(boundary.vertices), components.pieces, {},
               &stop);
    FAIL("the loops were traced");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kInterrupted);
  }
}

}  // namespace orbweave
