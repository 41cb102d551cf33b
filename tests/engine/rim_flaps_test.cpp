// Triangles at rims onto whose backs patches would fold: the boundary and the sheet stay sound.
#include "engine/holes/patch/rim_flaps.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>
#include <utility>

#include "engine/holes/fill_mesh.h"
#include "engine/holes/loops/mesh_surface.h"
#include "engine/validation/mesh_facts.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

/// A floor of crumpled foil with a small hole here and there.
TriangleMesh crumpled_floor(std::uint64_t seed) {
  constexpr std::size_t kSide = 60;
  std::mt19937_64 random(seed);
  const auto share = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  TriangleMesh mesh = test::square_mesh(kSide);
  for (Vec3& p : mesh.vertices.positions)
    p = p + (1.5 / kSide) * Vec3{share() - 0.5, share() - 0.5, share() - 0.5};
  std::erase_if(mesh.triangles, [&](const Triangle&) { return share() < 0.1; });
  return mesh;
}

struct Boundary {
  MeshComponents components;
  MeshBoundary found;
  std::vector<BoundaryLoop> loops;
};

Boundary boundary_of(const TriangleMesh& mesh) {
  const MeshSurface surface(mesh);
  Boundary boundary{find_components(mesh, surface), {}, {}};
  boundary.found = find_boundary(mesh, surface, boundary.components.of_triangle);
  boundary.loops = trace_loops(boundary.found.fans, boundary.found.vertices);
  return boundary;
}

RimFlaps take(const TriangleMesh& mesh, Boundary& boundary) {
  const std::vector<std::uint8_t> all(boundary.loops.size(), 1);
  return take_rim_flaps(all, MeshSurface(mesh), boundary.loops, boundary.found.fans,
                        boundary.found.vertices);
}

TriangleMesh without(TriangleMesh mesh, const std::vector<Triangle64>& taken) {
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    const Triangle64 known = smallest_first(Triangle64{t[0], t[1], t[2]});
    return std::binary_search(taken.begin(), taken.end(), known);
  });
  return mesh;
}

std::set<Triangle64> places_of(const std::vector<OpenFan>& fans) {
  std::set<Triangle64> places;
  for (const OpenFan& fan : fans) places.insert({fan.previous, fan.vertex, fan.next});
  return places;
}

/// A floor with a hole of one cell, and a triangle at one of its edges that is bent back over the
/// floor, nearly onto it.
TriangleMesh floor_with_flap() {
  constexpr double kStep = 1.0 / 40.0;
  TriangleMesh mesh = test::square_mesh(40);
  test::cut(mesh, [](Vec3 p) { return p.x > 0.5 && p.x < 0.525 && p.y > 0.5 && p.y < 0.525; });
  const auto vertex_at = [&](Vec3 place) {
    const std::vector<Vec3>& at = mesh.vertices.positions;
    const auto is_there = [&](Vec3 p) { return norm(p - place) < 0.1 * kStep; };
    return static_cast<std::uint32_t>(std::find_if(at.begin(), at.end(), is_there) - at.begin());
  };
  const std::uint32_t a = vertex_at({0.5, 0.5, 0.0}), b = vertex_at({0.5, 0.525, 0.0});
  const auto tip = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.append(mesh.vertices, a);
  mesh.vertices.positions[tip] = {0.5 - 0.6 * kStep, 0.5 + 0.5 * kStep, 0.2 * kStep};
  mesh.triangles.push_back({b, a, tip});
  return mesh;
}

HoleFacts gap_of(const FilledMesh& filled) {
  return *std::find_if(filled.holes.begin(), filled.holes.end(),
                       [](const HoleFacts& hole) { return hole.diameter < 0.5; });
}

}  // namespace

TEST_CASE("TheBoundaryWithoutFlapsIsThatOfTheMeshWithoutThem") {
  std::size_t freed = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const TriangleMesh mesh = crumpled_floor(seed);
    Boundary boundary = boundary_of(mesh);
    const std::size_t loops = boundary.loops.size();
    const RimFlaps flaps = take(mesh, boundary);
    INFO("seed " << seed << ", flaps " << flaps.triangles.size() << ", loops " << loops);
    CHECK(flaps.triangles.size() > 10);
    freed += flaps.freed.size();
    const TriangleMesh left = without(mesh, flaps.triangles);
    REQUIRE(left.triangles.size() + flaps.triangles.size() == mesh.triangles.size());
    const Boundary expected = boundary_of(left);
    CHECK(places_of(boundary.found.fans) == places_of(expected.found.fans));
    CHECK(boundary.found.fans.size() == expected.found.fans.size());
    // No loop is lost, and the edges of all are the boundary's.
    CHECK(boundary.loops.size() == loops);
    CHECK(std::is_sorted(boundary.loops.begin(), boundary.loops.end(),
                         [](const auto& a, const auto& b) { return a.vertices < b.vertices; }));
    std::set<std::pair<std::uint64_t, std::uint64_t>> edges, of_fans;
    for (const BoundaryLoop& loop : boundary.loops) {
      CHECK(loop.vertices.size() >= 3);
      for (std::size_t i = 0; i < loop.vertices.size(); ++i)
        edges.emplace(loop.vertices[(i + 1) % loop.vertices.size()], loop.vertices[i]);
    }
    for (const OpenFan& fan : expected.found.fans) of_fans.emplace(fan.vertex, fan.next);
    CHECK(edges == of_fans);
    for (const BoundaryVertex& known : expected.found.vertices)
      CHECK(std::binary_search(boundary.found.vertices.begin(), boundary.found.vertices.end(),
                               known,
                               [](const auto& a, const auto& b) { return a.vertex < b.vertex; }));
    // The sheet hangs together as it did, and the vertices that are not used any more are told.
    CHECK(expected.components.pieces.size() == boundary.components.pieces.size());
    CHECK(mesh_facts(left).unreferenced_vertices ==
          mesh_facts(mesh).unreferenced_vertices + flaps.freed.size());
    CHECK(flaps.area == Approx(mesh_facts(mesh).area - mesh_facts(left).area).epsilon(1e-9));
  }
  CHECK(freed > 0);
}

TEST_CASE("APatchDoesNotFoldOverATriangleThatIsBentBack") {
  const TriangleMesh mesh = floor_with_flap();
  const FilledMesh kept = fill_mesh(mesh, {});
  CHECK(gap_of(kept).edges == 5);
  CHECK(gap_of(kept).rim_dihedral_deg > 120.0);
  CHECK(kept.triangles_mended == 0);
  const FilledMesh filled = fill_mesh(mesh, {}, {.takes_flaps = true});
  CHECK(gap_of(filled).filled);
  CHECK(gap_of(filled).edges == 4);
  CHECK(gap_of(filled).rim_dihedral_deg < 1.0);
  CHECK(filled.triangles_mended == 1);
  CHECK(filled.mesh.vertices.size() == mesh.vertices.size() - 1);
  CHECK(filled.mesh.triangles.size() == mesh.triangles.size() - 1 + 2);
  CHECK(validate_mesh(filled.mesh).empty());
  CHECK(mesh_facts(filled.mesh).boundary_edges == 160);
}

TEST_CASE("NoFlapIsTakenOffAClosedObject") {
  TriangleMesh ball = test::sphere_mesh(4);
  std::mt19937_64 random(4);
  std::erase_if(ball.triangles, [&](const Triangle&) { return random() % 16 == 0; });
  for (Vec3& p : ball.vertices.positions)
    p = p * (1.0 + 0.1 * static_cast<double>(random() >> 11) * 0x1p-53);
  const FilledMesh kept = fill_mesh(ball, {});
  const FilledMesh filled = fill_mesh(ball, {}, {.takes_flaps = true});
  CHECK(filled.triangles_mended == kept.triangles_mended);
  CHECK(filled.mesh.vertices.positions == kept.mesh.vertices.positions);
  CHECK(filled.mesh.triangles == kept.mesh.triangles);
}

}  // namespace orbweave
