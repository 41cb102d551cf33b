// Holes that are hard, each with what has to come out.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <set>
#include <span>

#include "engine/holes/fill_mesh.h"
#include "engine/holes/hole_pass.h"
#include "engine/holes/loops/mesh_surface.h"
#include "engine/validation/mesh_facts.h"
#include "tests/engine/filled_meshes.h"
#include "tests/support/meshes.h"

namespace orbweave {

using namespace test;

TEST_CASE("ThreeAndFourEdgeHolesAreClosedWithoutNewPoints") {
  const TriangleMesh whole = test::torus_mesh(4000);
  for (const std::size_t missing : {1u, 2u}) {
    TriangleMesh mesh = whole;
    mesh.triangles.resize(mesh.triangles.size() - missing);
    const FilledMesh filled = fill_mesh(mesh, {});
    require_closed(mesh, filled);
    REQUIRE(filled.holes.size() == 1);
    CHECK(filled.holes[0].edges == missing + 2);
    CHECK(filled.mesh.vertices.size() == mesh.vertices.size());
    CHECK(filled.mesh.triangles.size() == whole.triangles.size());
  }
}

TEST_CASE("ANewVertexInAHoleOfThreeEdgesHasAttributes") {
  // The only triangle between the corners is in use: the patch needs a vertex of its own.
  TriangleMesh mesh;
  mesh.vertices.schema.attributes = {{"height", ScalarType::kFloat64}};
  mesh.vertices.positions = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  mesh.vertices.attributes.resize(3 * sizeof(double));
  const std::array<double, 3> heights = {6.0, 6.0, 6.0};
  std::memcpy(mesh.vertices.attributes.data(), heights.data(), sizeof heights);
  mesh.triangles = {{0, 1, 2}};
  FillOptions options;
  options.keep_outer_border = false;
  options.allow_intersections = true;
  const FilledMesh filled = fill_mesh(mesh, options);
  REQUIRE(filled.mesh.vertices.size() == 4);
  REQUIRE(filled.mesh.vertices.attributes.size() == 4 * sizeof(double));
  double height = 0.0;
  std::memcpy(&height, filled.mesh.vertices.attributes.data() + sizeof heights, sizeof height);
  CHECK(height == 6.0);
}

TEST_CASE("AHoleInASphereIsFilledOnTheSphere") {
  TriangleMesh mesh = test::sphere_mesh(5);
  const std::size_t whole = mesh.vertices.size();
  const double spacing = norm(mesh.vertices.positions[mesh.triangles[0][0]] -
                              mesh.vertices.positions[mesh.triangles[0][1]]);
  cut(mesh, [](Vec3 p) { return norm(p - Vec3{0.6, 0.48, 0.64}) < 0.25; });
  const FilledMesh filled = fill_mesh(mesh, {});
  require_closed(mesh, filled);
  CHECK(filled.holes.at(0).method == "plane");
  // About as many points as were taken out.
  const double taken_out = static_cast<double>(whole - mesh.vertices.size());
  const double added = static_cast<double>(filled.mesh.vertices.size() - mesh.vertices.size());
  CHECK(added > 0.7 * taken_out);
  CHECK(added < 1.5 * taken_out);
  CHECK(farthest_new_vertex(mesh, filled, off_sphere) < 0.1 * spacing);
}

TEST_CASE("TheBorderOfASheetStaysOpenAndItsHolesAreFilled", "[costly]") {
  TriangleMesh mesh = moved(test::square_mesh(60), [](Vec3 p) {
    return Vec3{p.x, p.y, 0.05 * std::sin(7.0 * p.x) * std::cos(5.0 * p.y)};
  });
  const Vec3 centers[] = {{0.3, 0.3, 0.0}, {0.7, 0.35, 0.0}, {0.5, 0.75, 0.0}};
  cut(mesh, [&](Vec3 p) {
    return std::any_of(std::begin(centers), std::end(centers), [&](Vec3 center) {
      return std::hypot(p.x - center.x, p.y - center.y) < 0.1;
    });
  });
  const FilledMesh filled = fill_mesh(mesh, {});
  require_sound(mesh, filled);
  REQUIRE(filled.holes.size() == 4);
  CHECK(count_filled(filled) == 3);
  const MeshFacts facts = mesh_facts(filled.mesh);
  CHECK(facts.boundary_loops == 1);
  CHECK(facts.boundary_edges == 240);
  CHECK(farthest_new_vertex(mesh, filled, [](Vec3 p) {
          return p.z - 0.05 * std::sin(7.0 * p.x) * std::cos(5.0 * p.y);
        }) < 0.002);
  FillOptions all;
  all.keep_outer_border = false;
  all.allow_intersections = true;  // nothing closes a border without running into the sheet
  require_closed(mesh, fill_mesh(mesh, all));
}

TEST_CASE("TheEndsOfALongTubeAreClosed") {
  const TriangleMesh mesh = tube(10.0);
  const FilledMesh filled = fill_mesh(mesh, {});
  require_closed(mesh, filled);
  CHECK(count_filled(filled) == 2);
  // A cap, not a spike nor a bubble.
  CHECK(farthest_new_vertex(mesh, filled, [](Vec3 p) {
          return std::max({0.0, -p.z, p.z - 10.0, std::hypot(p.x, p.y) - 1.0});
        }) < 1.2);
}

TEST_CASE("ATunnelThroughADoubleWallIsClosedOnBothSides") {
  constexpr double kGap = 0.05;
  TriangleMesh lower = test::flipped(test::square_mesh(40));
  const TriangleMesh upper = moved(test::square_mesh(40), [](Vec3 p) {
    return p + Vec3{0, 0, kGap};
  });
  TriangleMesh mesh = test::joined(lower, upper);
  cut(mesh, [](Vec3 p) { return std::hypot(p.x - 0.5, p.y - 0.5) < 0.2; });
  const FilledMesh filled = fill_mesh(mesh, {});
  require_sound(mesh, filled);
  CHECK(count_filled(filled) == 2);
  const MeshFacts facts = mesh_facts(filled.mesh);
  CHECK(facts.boundary_loops == 2);  // the outer borders
  CHECK(facts.components == 2);
  CHECK(farthest_new_vertex(mesh, filled, [](Vec3 p) {
          return std::min(std::abs(p.z), std::abs(p.z - kGap));
        }) < 1e-9);
}

TEST_CASE("AHoleOverASharpEdgeIsClosed") {
  TriangleMesh mesh = test::cube_mesh(24);
  cut(mesh, [](Vec3 p) { return norm(p - Vec3{1.0, 0.5, 1.0}) < 0.25; });
  const FilledMesh filled = fill_mesh(mesh, {});
  require_closed(mesh, filled);
  CHECK(farthest_new_vertex(mesh, filled, [](Vec3 p) {
          return std::max({0.0, std::abs(p.x - 0.5) - 0.5, std::abs(p.y - 0.5) - 0.5,
                           std::abs(p.z - 0.5) - 0.5});
        }) < 0.1);
}

TEST_CASE("ACornerOfACubeIsClosed") {
  TriangleMesh mesh = test::cube_mesh(24);
  cut(mesh, [](Vec3 p) { return norm(p - Vec3{1.0, 1.0, 1.0}) < 0.3; });
  require_closed(mesh, fill_mesh(mesh, {}));
}

TEST_CASE("AHemisphereStaysOpenUnlessAskedFor") {
  TriangleMesh mesh = test::sphere_mesh(4);
  cut(mesh, [](Vec3 p) { return p.z < 0.0; });
  const FilledMesh open = fill_mesh(mesh, {});
  CHECK(count_filled(open) == 0);
  CHECK(open.holes.at(0).reason.find("keep_outer_border") != std::string::npos);
  FillOptions all;
  all.keep_outer_border = false;
  const FilledMesh filled = fill_mesh(mesh, all);
  require_closed(mesh, filled);
  CHECK(mesh_facts(filled.mesh).euler_characteristic == 2);
  // Somewhere between a flat lid and a little more than the other half.
  CHECK(farthest_new_vertex(mesh, filled, [](Vec3 p) { return std::max(0.0, norm(p) - 1.0); }) <
        0.3);
}

TEST_CASE("HolesThatTouchInAVertexAreTwoAndLeaveItSound") {
  TriangleMesh mesh = test::square_mesh(40);
  cut(mesh, [](Vec3 p) {
    return std::max(std::abs(p.x - 0.4), std::abs(p.y - 0.4)) < 0.1 ||
           std::max(std::abs(p.x - 0.6), std::abs(p.y - 0.6)) < 0.1;
  });
  REQUIRE(mesh_facts(mesh).nonmanifold_vertices == 1);
  const FilledMesh filled = fill_mesh(mesh, {});
  require_sound(mesh, filled);
  CHECK(filled.holes.size() == 3);
  CHECK(count_filled(filled) == 2);
  CHECK(mesh_facts(filled.mesh).boundary_loops == 1);
  // No vertex had to be doubled: the two patches join the two fans.
  CHECK(mesh_facts(filled.mesh).euler_characteristic == 1);
}

TEST_CASE("AFigureEightLoopIsClosed") {
  // A flake that hangs in the hole by one vertex: the loop visits it twice.
  TriangleMesh mesh = test::square_mesh(40);
  cut(mesh, [](Vec3 p) {
    const bool in_hole = std::max(std::abs(p.x - 0.5), std::abs(p.y - 0.5)) < 0.2;
    const bool in_flake = p.x > 0.3 && p.x < 0.4 && p.y > 0.3 && p.y < 0.4;
    return in_hole && !(in_flake && p.x - 0.3 > 0.0);
  });
  // Cut the flake loose but for its corner.
  cut(mesh, [](Vec3 p) {
    const bool beside = (p.x < 0.325 && p.x > 0.3 && p.y > 0.325 && p.y < 0.4) ||
                        (p.y < 0.325 && p.y > 0.3 && p.x > 0.325 && p.x < 0.4);
    const bool corner = p.x > 0.3 && p.x < 0.325 && p.y > 0.3 && p.y < 0.325;
    return beside || corner;
  });
  const FilledMesh filled = fill_mesh(mesh, {});
  require_sound(mesh, filled);
}

TEST_CASE("AnIslandInAHoleIsJoinedToTheRest") {
  const auto ground = [](Vec3 p) {
    return Vec3{p.x, p.y, 0.03 * std::sin(6.0 * p.x) * std::cos(5.0 * p.y)};
  };
  TriangleMesh mesh = moved(test::square_mesh(60), ground);
  const auto radius = [](Vec3 p, Vec3 center) {
    return std::hypot(p.x - center.x, p.y - center.y);
  };
  cut(mesh, [&](Vec3 p) {
    const bool in_hole = radius(p, {0.5, 0.5, 0}) < 0.3;
    return in_hole && radius(p, {0.4, 0.5, 0}) > 0.08 && radius(p, {0.6, 0.45, 0}) > 0.06;
  });
  REQUIRE(mesh_facts(mesh).components == 3);
  const FilledMesh filled = fill_mesh(mesh, {});
  require_sound(mesh, filled);
  const MeshFacts facts = mesh_facts(filled.mesh);
  CHECK(facts.components == 1);
  CHECK(facts.boundary_loops == 1);
  CHECK(facts.euler_characteristic == 1);
  CHECK(std::count_if(filled.holes.begin(), filled.holes.end(),
                      [](const HoleFacts& hole) { return hole.joined_to != 0; }) == 2);
  CHECK(farthest_new_vertex(mesh, filled, [&](Vec3 p) { return p.z - ground(p).z; }) < 0.003);
  // The way over to the island is as fine as the rest.
  double longest = 0.0;
  for (std::size_t t = mesh.triangles.size(); t < filled.mesh.triangles.size(); ++t) {
    const Triangle& corners = filled.mesh.triangles[t];
    const std::vector<Vec3>& at = filled.mesh.vertices.positions;
    for (int k = 0; k < 3; ++k) {
      longest = std::max(longest, norm(at[corners[k]] - at[corners[(k + 1) % 3]]));
    }
  }
  CHECK(longest < 4.0 / 60.0);
}

TEST_CASE("APieceThatFacesTheOtherWayIsNoIsland") {
  TriangleMesh mesh = test::square_mesh(40);
  cut(mesh, [](Vec3 p) { return std::hypot(p.x - 0.5, p.y - 0.5) < 0.3; });
  const TriangleMesh piece = moved(test::flipped(test::square_mesh(6)), [](Vec3 p) {
    return Vec3{0.45 + 0.1 * p.x, 0.45 + 0.1 * p.y, -0.1};
  });
  mesh = test::joined(mesh, piece);
  const FilledMesh filled = fill_mesh(mesh, {});
  require_sound(mesh, filled);
  CHECK(mesh_facts(filled.mesh).components == 2);
  CHECK(count_filled(filled) == 1);
}

TEST_CASE("AnotherSheetCloseBehindDoesNotBendThePatch") {
  constexpr double kGap = 0.01;  // less than half an edge
  const TriangleMesh behind = moved(test::flipped(test::square_mesh(40)), [](Vec3 p) {
    return p - Vec3{0, 0, kGap};
  });
  TriangleMesh front = test::square_mesh(40);
  cut(front, [](Vec3 p) { return std::hypot(p.x - 0.5, p.y - 0.5) < 0.15; });
  const TriangleMesh mesh = test::joined(front, behind);
  const FilledMesh filled = fill_mesh(mesh, {});
  require_sound(mesh, filled);
  CHECK(count_filled(filled) == 1);
  CHECK(farthest_new_vertex(mesh, filled, [](Vec3 p) { return p.z; }) < 1e-9);
}

TEST_CASE("SmallAndLargeAndFarMeshesAreFilledAlike") {
  TriangleMesh mesh = test::sphere_mesh(4);
  cut(mesh, [](Vec3 p) { return norm(p - Vec3{0.0, 0.6, 0.8}) < 0.4; });
  const FilledMesh expected = fill_mesh(mesh, {});
  require_closed(mesh, expected);
  const auto with = [&](double scale, Vec3 offset) {
    const TriangleMesh other = moved(mesh, [&](Vec3 p) { return scale * p + offset; });
    const FilledMesh filled = fill_mesh(other, {});
    require_closed(other, filled);
    CHECK(filled.holes.at(0).method == expected.holes.at(0).method);
    CHECK(farthest_new_vertex(other, filled,
                              [&](Vec3 p) { return off_sphere((p - offset) / scale); }) < 0.02);
  };
  with(1e-6, {});
  with(1e6, {});
  with(10.0, {500'000.0, 5'000'000.0, 300.0});
}

TEST_CASE("TheResultDoesNotDependOnTheOrderOfTriangles") {
  TriangleMesh mesh = test::torus_mesh(4000);
  cut(mesh, [](Vec3 p) { return norm(p - Vec3{1.0, 0.0, 0.4}) < 0.3; });
  const FilledMesh expected = fill_mesh(mesh, {});
  TriangleMesh turned = mesh;
  std::reverse(turned.triangles.begin(), turned.triangles.end());
  for (Triangle& t : turned.triangles) t = {t[1], t[2], t[0]};
  const FilledMesh filled = fill_mesh(turned, {});
  REQUIRE(filled.mesh.vertices.positions == expected.mesh.vertices.positions);
  REQUIRE(std::equal(
      filled.mesh.triangles.begin() + turned.triangles.size(), filled.mesh.triangles.end(),
      expected.mesh.triangles.begin() + mesh.triangles.size(), expected.mesh.triangles.end()));
}

TEST_CASE("LimitsLeaveHolesOpenAndSayWhy") {
  TriangleMesh mesh = test::torus_mesh(4000);
  cut(mesh, [](Vec3 p) { return norm(p - Vec3{1.0, 0.0, 0.4}) < 0.3; });
  const auto reason_with = [&](auto&& limit) {
    FillOptions options;
    limit(options);
    const FilledMesh filled = fill_mesh(mesh, options);
    REQUIRE(filled.holes.size() == 1);
    CHECK_FALSE(filled.holes[0].filled);
    CHECK(filled.mesh.triangles.size() == mesh.triangles.size());
    CHECK(list_holes(mesh, options).at(0).reason == filled.holes[0].reason);
    return filled.holes[0].reason;
  };
  CHECK(reason_with([](FillOptions& o) { o.max_edges = 5; }).find("fill.max_edges = 5") !=
        std::string::npos);
  CHECK(reason_with([](FillOptions& o) { o.max_diameter = 0.1; }).find("fill.max_diameter") !=
        std::string::npos);
  CHECK(reason_with([](FillOptions& o) { o.max_perimeter = 0.1; }).find("fill.max_perimeter") !=
        std::string::npos);
}

namespace {

/// Notes which vertices were asked for.
class AskedSurface : public MeshSurface {
 public:
  using MeshSurface::MeshSurface;
  void triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const override {
    asked.insert(vertex);
    MeshSurface::triangles_at(vertex, out);
  }
  void new_triangles_at(std::span<const std::uint64_t> vertices, TriangleMarks& met,
                        std::vector<Triangle64>& out) const override {
    asked.insert(vertices.begin(), vertices.end());
    MeshSurface::new_triangles_at(vertices, met, out);
  }
  mutable std::set<std::uint64_t> asked;
};

/// How many vertices of the square in 160 cells a side are looked at to fill its only hole.
std::size_t vertices_around_hole(const std::function<bool(Vec3 steps)>& gone) {
  constexpr std::size_t kSide = 160;
  TriangleMesh sheet = test::square_mesh(kSide);
  cut(sheet, [&](Vec3 p) { return gone(double(kSide) * (p - Vec3{0.5, 0.5, 0.0})); });
  const AskedSurface surface(sheet);
  const MeshComponents components = find_components(sheet, surface);
  MeshBoundary boundary = find_boundary(sheet, surface, components.of_triangle);
  const FillOptions options;
  const HolePlan plan =
      plan_holes(std::move(boundary.fans), boundary.vertices, components.pieces, options);
  REQUIRE(plan.groups.size() == 1);
  surface.asked.clear();
  REQUIRE(fill_group(surface, plan, plan.groups[0], options).at(0).facts.filled);
  return surface.asked.size();
}

}  // namespace

TEST_CASE("AroundALongHoleOnlyWhatIsNearItsRimIsLookedAt") {
  // Both have some 120 edges. A circle's neighbourhood is limited by its radius, a slit's, of which
  // twice the radius is the length, by its edges: a quarter of their square, and a ring.
  const std::size_t around_slit =
      vertices_around_hole([](Vec3 p) { return std::abs(p.x) < 30.0 && std::abs(p.y) < 0.75; });
  const std::size_t around_disc =
      vertices_around_hole([](Vec3 p) { return std::hypot(p.x, p.y) < 16.0; });
  CHECK(around_slit < 5000);  // 11,000 lie within twice the radius
  CHECK(around_disc > 1500);
}

TEST_CASE("SmallPiecesAreRemovedOnRequest") {
  const TriangleMesh crumb = moved(test::square_mesh(2), [](Vec3 p) { return 0.1 * p; });
  const TriangleMesh torus = test::torus_mesh(1000);
  const TriangleMesh mesh = test::joined(crumb, torus);
  const FilledMesh kept = fill_mesh(mesh, {});
  CHECK(kept.pieces_removed == 0);
  CHECK(mesh_facts(kept.mesh).components == 2);
  FillOptions options;
  options.min_triangles = 9;
  const FilledMesh filled = fill_mesh(mesh, options);
  CHECK(filled.pieces_removed == 1);
  CHECK(filled.triangles_removed == 8);
  CHECK(mesh_facts(filled.mesh).watertight);
}

}  // namespace orbweave
