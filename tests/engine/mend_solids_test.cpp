// Closed objects that the fill alone would not close, or close only with doubled vertices.
#include "engine/holes/mend_solids.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <tuple>

#include "engine/holes/fill_mesh.h"
#include "engine/holes/loops/crumbs.h"
#include "engine/validation/mesh_crossings.h"
#include "engine/validation/mesh_facts.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

using test::cut;
using test::joined;
using test::moved;

/// Places where several vertices of the mesh lie.
std::size_t places_of_copies(const TriangleMesh& mesh) {
  std::multiset<std::tuple<double, double, double>> places;
  for (const Vec3 p : mesh.vertices.positions) places.emplace(p.x, p.y, p.z);
  std::size_t copies = 0;
  for (auto at = places.begin(); at != places.end(); at = places.upper_bound(*at))
    copies += places.count(*at) > 1 ? 1 : 0;
  return copies;
}

/// One vertex in place of two.
TriangleMesh welded(TriangleMesh mesh, std::uint32_t kept, std::uint32_t gone) {
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& vertex : t) {
      if (vertex == gone) vertex = kept;
      if (vertex > gone) --vertex;
    }
  PointCloud vertices;
  vertices.schema = mesh.vertices.schema;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v)
    if (v != gone) vertices.append(mesh.vertices, v);
  mesh.vertices = std::move(vertices);
  return mesh;
}

std::uint32_t nearest(const TriangleMesh& mesh, Vec3 place, std::uint32_t first,
                      std::uint32_t last) {
  std::uint32_t best = first;
  for (std::uint32_t v = first; v < last; ++v)
    if (norm(mesh.vertices.positions[v] - place) < norm(mesh.vertices.positions[best] - place))
      best = v;
  return best;
}

/// Two spheres that have one vertex in common.
TriangleMesh touching_spheres() {
  const TriangleMesh left = test::sphere_mesh(4);
  const TriangleMesh right = moved(left, [](Vec3 p) { return p + Vec3{2.0, 0.0, 0.0}; });
  const TriangleMesh both = joined(left, right);
  const auto half = static_cast<std::uint32_t>(left.vertices.size());
  const Vec3 place{1.0, 0.0, 0.0};
  return welded(both, nearest(both, place, 0, half), nearest(both, place, half, 2 * half));
}

/// A sphere with a hole, through which the end of a second sheet sticks out.
TriangleMesh sphere_with_flap() {
  TriangleMesh sphere = test::sphere_mesh(4);
  cut(sphere, [](Vec3 p) { return p.z > 0.0 && std::hypot(p.x, p.y) < 0.3; });
  // A strip that hangs on the rim at one edge and goes up through the gap beside it.
  std::uint32_t rim =
      nearest(sphere, {0.3, 0.0, 0.95}, 0, static_cast<std::uint32_t>(sphere.vertices.size()));
  std::uint32_t other = rim;
  double best = 1.0;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Triangle& t : sphere.triangles)
    for (int k = 0; k < 3; ++k) edges.emplace(t[k], t[(k + 1) % 3]);
  for (const auto& [tail, head] : edges) {
    if (edges.contains({head, tail})) continue;
    const Vec3 at = 0.5 * (sphere.vertices.positions[tail] + sphere.vertices.positions[head]);
    const double off = norm(at - Vec3{0.3, 0.0, 0.95});
    if (off >= best) continue;
    best = off;
    rim = head;
    other = tail;
  }
  const auto first = static_cast<std::uint32_t>(sphere.vertices.size());
  const auto add = [&](Vec3 p) {
    sphere.vertices.append(sphere.vertices, 0);
    sphere.vertices.positions.back() = p;
  };
  const Vec3 a = sphere.vertices.positions[rim], b = sphere.vertices.positions[other];
  add({0.0, a.y, 0.8});
  add({0.0, b.y, 0.8});
  add({-0.1, a.y, 1.2});
  add({-0.1, b.y, 1.2});
  sphere.triangles.push_back({rim, other, first});
  sphere.triangles.push_back({other, first + 1, first});
  sphere.triangles.push_back({first, first + 1, first + 2});
  sphere.triangles.push_back({first + 1, first + 3, first + 2});
  return sphere;
}

void require_solid(const TriangleMesh& mesh) {
  REQUIRE(validate_mesh(mesh).empty());
  const MeshFacts facts = mesh_facts(mesh);
  CHECK(facts.watertight);
  CHECK(facts.nonmanifold_edges == 0);
  CHECK(facts.unreferenced_vertices == 0);
  CHECK(places_of_copies(mesh) == 0);
  CHECK(count_crossing_pairs(mesh) == 0);
}

}  // namespace

TEST_CASE("SpheresThatTouchInAVertexArePartedWithoutACopyOrACrossing") {
  const TriangleMesh mesh = touching_spheres();
  REQUIRE(mesh_facts(mesh).nonmanifold_vertices == 1);
  const FilledMesh filled = fill_mesh(mesh, {});
  require_solid(filled.mesh);
  CHECK(filled.vertices_doubled == 0);
  CHECK(filled.triangles_mended > 0);
  CHECK(filled.triangles_mended < 30);
  CHECK(mesh_facts(filled.mesh).components == 2);
  REQUIRE(filled.holes.size() == 1);
  CHECK(filled.holes[0].filled);
  CHECK(filled.holes[0].triangles_added ==
        static_cast<std::uint64_t>(
            std::count(filled.mesh.hole.begin(), filled.mesh.hole.end(), filled.holes[0].id)));
}

TEST_CASE("WhatSticksOutOfAHoleOfAClosedObjectIsTakenOutAndTheHoleClosed") {
  const TriangleMesh mesh = sphere_with_flap();
  REQUIRE(count_crossing_pairs(mesh) == 0);
  const FilledMesh filled = fill_mesh(mesh, {});
  require_solid(filled.mesh);
  CHECK(mesh_facts(filled.mesh).euler_characteristic == 2);
  CHECK(filled.triangles_mended < 60);
  FillOptions crossing;
  crossing.allow_intersections = true;
  CHECK(fill_mesh(mesh, crossing).triangles_mended == 0);
}

TEST_CASE("ASoundObjectAndAnOpenSheetAreNotMended") {
  TriangleMesh ball = test::sphere_mesh(4);
  cut(ball, [](Vec3 p) { return p.z > 0.0 && std::hypot(p.x, p.y) < 0.3; });
  CHECK(fill_mesh(ball, {}).triangles_mended == 0);
  TriangleMesh sheet = test::square_mesh(40);
  cut(sheet, [](Vec3 p) {
    return std::max(std::abs(p.x - 0.4), std::abs(p.y - 0.4)) < 0.1 ||
           std::max(std::abs(p.x - 0.6), std::abs(p.y - 0.6)) < 0.1;
  });
  CHECK(fill_mesh(sheet, {}).triangles_mended == 0);
}

TEST_CASE("SmallClosedComponentsOfAnOpenSceneAreNotMended") {
  const TriangleMesh spheres = moved(touching_spheres(), [](Vec3 p) { return p + Vec3{0, 0, 5}; });
  const TriangleMesh scene = joined(test::square_mesh(150), spheres);
  REQUIRE(scene.triangles.size() > 3 * spheres.triangles.size());
  const FilledMesh filled = fill_mesh(scene, {});
  CHECK(filled.triangles_mended == 0);
  CHECK(filled.vertices_doubled == 1);
}

TEST_CASE("MendingDoesNotDependOnTheOrderOfTriangles") {
  TriangleMesh mesh = joined(touching_spheres(), moved(sphere_with_flap(), [](Vec3 p) {
                               return p + Vec3{0.0, 4.0, 0.0};
                             }));
  const FilledMesh expected = fill_mesh(mesh, {});
  CHECK(expected.triangles_mended > 0);
  std::reverse(mesh.triangles.begin(), mesh.triangles.end());
  const FilledMesh filled = fill_mesh(mesh, {});
  CHECK(filled.mesh.vertices.positions == expected.mesh.vertices.positions);
  CHECK(filled.triangles_mended == expected.triangles_mended);
  CHECK(filled.mesh.triangles.size() == expected.mesh.triangles.size());
}

namespace {

/// A sheet's border of four edges about a place.
BoundaryLoop border(Vec3 center, double radius, std::uint64_t piece) {
  BoundaryLoop loop;
  loop.vertices = {4 * piece, 4 * piece + 1, 4 * piece + 2, 4 * piece + 3};
  loop.components = {piece};
  loop.perimeter = 5.6 * radius;
  loop.radius = radius;
  loop.center = center;
  loop.area_vector = {0.0, 0.0, -2.0 * radius * radius};
  loop.mean_normal = {0.0, 0.0, 1.0};
  return loop;
}

}  // namespace

TEST_CASE("LooseSheetsBesideAClosedObjectAreCrumbsAndThoseOfAScenesAreNot") {
  const Piece object{100'000, {{-1, -1, -1}, {1, 1, 1}}};
  const Piece sheet{100, {{-0.1, -0.1, 1.0}, {0.1, 0.1, 1.01}}};
  const Piece far{100, {{-0.1, -0.1, 9.0}, {0.1, 0.1, 9.01}}};
  const Piece large{5'000, {{-0.1, -0.1, 1.0}, {0.1, 0.1, 1.01}}};
  const std::vector<BoundaryLoop> loops = {border({0, 0, 1}, 0.1, 1), border({0, 0, 9}, 0.1, 2),
                                           border({0, 0, 1}, 0.1, 3)};
  const std::vector<Piece> pieces = {object, sheet, far, large};
  const std::vector<std::uint8_t> is_border = {1, 1, 1};
  CHECK(find_crumbs(loops, pieces, is_border) == std::vector<std::uint8_t>{0, 1, 0, 0});
  // The same sheet where the object has a border of its own: a terrain, a room.
  std::vector<BoundaryLoop> of_scene = loops;
  of_scene.push_back(border({0, 0, 0}, 1.4, 0));
  const std::vector<std::uint8_t> is_border_of_scene = {1, 1, 1, 1};
  CHECK(find_crumbs(of_scene, pieces, is_border_of_scene) == std::vector<std::uint8_t>{0, 0, 0, 0});
}

TEST_CASE("LooseSheetsThatTouchInAVertexAreCrumbsTogetherOrNotAtAll") {
  const Piece object{100'000, {{-1, -1, -1}, {1, 1, 1}}};
  const Piece left{90, {{-0.1, -0.1, 1.0}, {0.0, 0.1, 1.01}}};
  const Piece right{90, {{0.0, -0.1, 1.0}, {0.1, 0.1, 1.01}}};
  const std::vector<Piece> pieces = {object, left, right};
  // One loop runs around both sheets, through the vertex that they share; one has a hole.
  std::vector<BoundaryLoop> loops = {border({0, 0, 1}, 0.1, 1), border({0.05, 0, 1}, 0.01, 2)};
  loops[0].components = {1, 2};
  CHECK(find_crumbs(loops, pieces, std::vector<std::uint8_t>{1, 0}) ==
        std::vector<std::uint8_t>{0, 1, 1});
  std::vector<std::uint8_t> kept = {0, 1, 1};
  keep_pieces(loops, std::vector<std::uint64_t>{2}, kept);
  CHECK(kept == std::vector<std::uint8_t>{0, 0, 0});
  // A sheet that touches the object is a part of it.
  loops[1].components = {0, 2};
  CHECK(find_crumbs(loops, pieces, std::vector<std::uint8_t>{1, 0}) ==
        std::vector<std::uint8_t>{0, 0, 0});
  // Together they are no crumb.
  const std::vector<Piece> larger = {object, left, {150, right.box}};
  loops[1].components = {2};
  CHECK(find_crumbs(loops, larger, std::vector<std::uint8_t>{1, 0}) ==
        std::vector<std::uint8_t>{0, 0, 0});
}

}  // namespace orbweave
