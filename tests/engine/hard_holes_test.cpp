// Holes that are hard, each with what has to come out.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <set>
#include <span>

#include "engine/holes/fill_mesh.h"
#include "engine/holes/hole_pass.h"
#include "engine/holes/loops/mesh_surface.h"
#include "engine/holes/loops/open_scenes.h"
#include "engine/holes/patch/patch_confidence.h"
#include "engine/validation/mesh_facts.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

using test::cut;
using test::moved;

/// Whatever the hole: the given part stays as it was, and what is added is sound.
void require_sound(const TriangleMesh& before, const FilledMesh& filled) {
  const TriangleMesh& mesh = filled.mesh;
  REQUIRE(validate_mesh(mesh).empty());
  REQUIRE(mesh.vertices.size() >= before.vertices.size());
  REQUIRE(std::equal(before.vertices.positions.begin(), before.vertices.positions.end(),
                     mesh.vertices.positions.begin()));
  REQUIRE(mesh.triangles.size() >= before.triangles.size());
  REQUIRE(std::equal(before.triangles.begin(), before.triangles.end(), mesh.triangles.begin()));
  REQUIRE(mesh.hole.size() == mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    REQUIRE((mesh.hole[t] == 0) == (t < before.triangles.size()));
  }
  const MeshFacts facts = mesh_facts(mesh);
  REQUIRE(facts.nonmanifold_edges == 0);
  REQUIRE(facts.inconsistent_edges == 0);
  REQUIRE(facts.nonmanifold_vertices == 0);
}

void require_closed(const TriangleMesh& before, const FilledMesh& filled) {
  require_sound(before, filled);
  const MeshFacts facts = mesh_facts(filled.mesh);
  REQUIRE(facts.boundary_edges == 0);
  REQUIRE(facts.watertight);
}

std::size_t count_filled(const FilledMesh& filled) {
  return static_cast<std::size_t>(std::count_if(filled.holes.begin(), filled.holes.end(),
                                                [](const HoleFacts& hole) { return hole.filled; }));
}

/// Largest |distance(new vertex)|.
double farthest_new_vertex(const TriangleMesh& before, const FilledMesh& filled,
                           const std::function<double(Vec3)>& distance) {
  double farthest = 0.0;
  for (std::size_t v = before.vertices.size(); v < filled.mesh.vertices.size(); ++v) {
    farthest = std::max(farthest, std::abs(distance(filled.mesh.vertices.positions[v])));
  }
  return farthest;
}

double off_sphere(Vec3 p) { return norm(p) - 1.0; }

TriangleMesh tube(double length) {
  return test::grid_mesh(48, static_cast<std::size_t>(48.0 * length / 2.0 / std::numbers::pi) + 1,
                         true, [&](double u, double v) {
                           const double angle = 2.0 * std::numbers::pi * u;
                           return Vec3{std::cos(angle), std::sin(angle), length * v};
                         });
}

}  // namespace

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

TEST_CASE("WideGapsOfAnOpenSceneStayOpenAndThoseOfAnObjectAreClosed") {
  const auto cut_disc = [](TriangleMesh& mesh, double radius) {
    cut(mesh, [&](Vec3 p) { return std::hypot(p.x - 0.5, p.y - 0.5) < radius; });
  };
  TriangleMesh narrow = test::square_mesh(120), wide = narrow;
  cut_disc(narrow, 0.15);
  cut_disc(wide, 0.30);
  const FilledMesh closed = fill_mesh(narrow, {});
  require_sound(narrow, closed);
  CHECK(count_filled(closed) == 1);
  const FilledMesh open = fill_mesh(wide, {});
  REQUIRE(open.holes.size() == 2);
  CHECK(count_filled(open) == 0);
  CHECK((open.holes[0].open == OpenReason::kTooWide) !=
        (open.holes[1].open == OpenReason::kTooWide));
  FillOptions no_limit;
  no_limit.max_diameter = std::numeric_limits<double>::infinity();
  CHECK(count_filled(fill_mesh(wide, no_limit)) == 1);
  // All that is missing of an object seen from all around is closed.
  TriangleMesh ball = test::sphere_mesh(6);
  cut(ball, [](Vec3 p) { return p.z < -0.45; });
  const FilledMesh whole = fill_mesh(ball, {});
  require_closed(ball, whole);
  // The same seen from inside is a room, and the gap its door.
  const FilledMesh room = fill_mesh(test::flipped(ball), {});
  REQUIRE(room.holes.size() == 1);
  CHECK(room.holes[0].open == OpenReason::kTooWide);
}

TEST_CASE("RoomsLookInwardAtTheirSidesAndRingsInTheirMiddle") {
  const Box box{{-2.0, -1.0, 0.0}, {2.0, 1.0, 1.0}};
  const auto is_scene = [&](Vec3 center, Vec3 normal, double radius, bool border) {
    BoundaryLoop loop;
    loop.components = {1};
    loop.center = center;
    loop.mean_normal = normal;
    loop.radius = radius;
    loop.perimeter = 6.0 * radius;
    const std::vector<BoundaryLoop> loops(2, loop);
    const std::vector<std::uint8_t> borders = {0, static_cast<std::uint8_t>(border ? 1 : 0)};
    const std::vector<std::uint8_t> found =
        pieces_of_scenes(loops, std::vector<Piece>{{10, box}, {10, box}}, borders);
    CHECK(found[0] == 0);  // the other piece has no loop
    return found[1] != 0;
  };
  CHECK_FALSE(is_scene({0.0, 0.0, 0.02}, {0.0, 0.0, -1.0}, 0.5, false));  // an unseen base
  CHECK(is_scene({-1.95, 0.0, 0.5}, {1.0, 0.0, 0.0}, 0.2, false));        // a window
  CHECK(is_scene({1.0, 1.0, 0.5}, {0.0, -1.0, 0.0}, 0.2, false));
  CHECK_FALSE(is_scene({0.5, 0.0, 0.5}, {-1.0, 0.0, 0.0}, 0.2, false));  // inside a ring
  CHECK(is_scene({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 2.0, true));
  CHECK_FALSE(is_scene({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0.1, true));
}

TEST_CASE("AHoleBehindACreaseIsClosedFlat") {
  const TriangleMesh beaker = tube(2.0);  // without a bottom
  FillOptions options;
  options.keep_outer_border = false;
  const FilledMesh filled = fill_mesh(beaker, options);
  require_closed(beaker, filled);
  REQUIRE(count_filled(filled) == 2);
  for (const HoleFacts& hole : filled.holes) CHECK(hole.reason.starts_with("flat"));
  CHECK(farthest_new_vertex(beaker, filled, [&](Vec3 p) {
          return std::min(std::abs(p.z), std::abs(p.z - 2.0));
        }) < 1e-9);
  // The cap of a sphere bends towards the hole, and goes on bending.
  TriangleMesh ball = test::sphere_mesh(5);
  cut(ball, [](Vec3 p) { return p.z > 0.5; });
  const FilledMesh round = fill_mesh(ball, options);
  require_closed(ball, round);
  CHECK_FALSE(round.holes.at(0).reason.starts_with("flat"));
  CHECK(farthest_new_vertex(ball, round, off_sphere) < 0.3);
}

TEST_CASE("ThePaneOfAWindowLiesAtTheGroundOfItsReveal") {
  // A window in a wall, its reveal one edge wide and three deep.
  constexpr double kStep = 1.0 / 80.0, kDepth = 3.0 * kStep;
  constexpr double kPane = 11.0, kOpening = 12.0;  // half their widths, edges
  const auto along = [](double x) { return (x - 0.5) / kStep; };
  const auto with_window = [&](const auto& is_unseen) {
    TriangleMesh wall = test::square_mesh(80);
    cut(wall, [&](Vec3 p) { return is_unseen(along(p.x), along(p.y)); });
    return moved(std::move(wall), [&](Vec3 p) {
      const bool is_deep = std::max(std::abs(along(p.x)), std::abs(along(p.y))) < kPane + 0.5;
      return is_deep ? p - Vec3{0.0, 0.0, kDepth} : p;
    });
  };
  const auto check_pane = [&](const TriangleMesh& wall, const std::string& reason) {
    const FilledMesh filled = fill_mesh(wall, {});
    require_sound(wall, filled);
    REQUIRE(count_filled(filled) == 1);
    const auto pane = std::find_if(filled.holes.begin(), filled.holes.end(),
                                   [](const HoleFacts& hole) { return hole.filled; });
    CHECK_THAT(pane->reason, Catch::Contains(reason));
    CHECK(pane->points_added > 100);
    CHECK(pane->confidence > 0.85);
    CHECK(farthest_new_vertex(wall, filled, [&](Vec3 p) { return std::abs(p.z + kDepth); }) < 1e-9);
  };
  // The reveal is seen on three sides; on the fourth the scan ends at the edge of the wall.
  const auto from_the_side = [&](double x, double y) {
    return std::abs(y) < kPane && x > -kPane && x < kOpening;
  };
  check_pane(with_window(from_the_side), "at the ground of a recess");
  // The reveal is seen all around.
  const auto from_the_front = [&](double x, double y) {
    return std::abs(y) < kPane && std::abs(x) < kPane;
  };
  check_pane(with_window(from_the_front), "turns away all along the rim");
  // The scan ends at the edge of the wall nearly everywhere: half of one side is seen.
  const auto but_for_a_part = [&](double x, double y) {
    const bool is_seen = x < -kPane && std::abs(y) < 0.5 * kPane;
    return std::max(std::abs(x), std::abs(y)) < kOpening && !is_seen;
  };
  check_pane(with_window(but_for_a_part), "at the ground of a recess");
}

TEST_CASE("PatchesOfASceneThatFoldBackSaySo") {
  // A floor with a slit whose sides are thrust over each other half way along it: what joins the
  // edges there runs back between the two layers, underside up.
  const auto floor_with_slit = [](double thrust) {
    TriangleMesh mesh = test::square_mesh(100);
    cut(mesh, [](Vec3 p) { return std::abs(p.x - 0.5) < 0.021 && std::abs(p.y - 0.5) < 0.06; });
    for (Vec3& p : mesh.vertices.positions) {
      const double share = std::max(0.0, 1.0 - std::abs(p.y - 0.5) / 0.03) *
                           std::max(0.0, 1.0 - std::abs(p.x - 0.5) / 0.2);
      const bool is_left = p.x < 0.5;
      p.x += (is_left ? thrust : -thrust) * share;
      p.z += is_left ? 0.0 : 0.5 * std::abs(thrust) * share;
    }
    return mesh;
  };
  const auto slit_of = [](const FilledMesh& filled) {
    return *std::find_if(filled.holes.begin(), filled.holes.end(),
                         [](const HoleFacts& hole) { return hole.diameter < 0.5; });
  };
  const HoleFacts folded = slit_of(fill_mesh(floor_with_slit(0.05), {}));
  CHECK(folded.filled);
  CHECK_THAT(folded.reason, Catch::Contains("folds back"));
  // Without a thrust the slit is a hole like others.
  const HoleFacts plain = slit_of(fill_mesh(floor_with_slit(0.0), {}));
  CHECK(plain.filled);
  CHECK_THAT(plain.reason, !Catch::Contains("folds back"));
}

TEST_CASE("WideGapsOfAnOpenSceneThatSomethingStandsInStayOpen") {
  // A floor with a gap, and a blade that leans from its edge across all of it.
  const auto floor_with_blade = [](double radius) {
    TriangleMesh mesh = test::square_mesh(120);
    cut(mesh, [&](Vec3 p) { return std::hypot(p.x - 0.5, p.y - 0.5) < radius; });
    const FilledMesh whole = fill_mesh(mesh, {});
    REQUIRE(count_filled(whole) == 1);
    const Vec3 middle{0.5, 0.5, 0.0};
    std::vector<Vec3>& at = mesh.vertices.positions;
    const auto foot = static_cast<std::uint32_t>(
        std::min_element(at.begin(), at.end(),
                         [&](Vec3 a, Vec3 b) { return norm(a - middle) < norm(b - middle); }) -
        at.begin());
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const Vec3 far = at[foot] + 1.9 * (middle - at[foot]), up{0.0, 0.0, 0.4 * radius};
    at.push_back(far + up);
    at.push_back(far - up);
    mesh.triangles.push_back({foot, first, first + 1});
    return mesh;
  };
  const auto gap_of = [](const FilledMesh& filled) {
    return *std::find_if(filled.holes.begin(), filled.holes.end(), [](const HoleFacts& hole) {
      return hole.edges > 8 && hole.diameter < 0.5;
    });
  };
  const HoleFacts wide = gap_of(fill_mesh(floor_with_blade(0.15), {}));
  CHECK(wide.edges > 48);
  CHECK_FALSE(wide.filled);
  CHECK(wide.open == OpenReason::kTooWide);
  CHECK_THAT(wide.reason, Catch::Contains("every patch crosses the surface"));
  // A small one is closed beside the blade, and a wide one where that is asked for.
  const HoleFacts narrow = gap_of(fill_mesh(floor_with_blade(0.04), {}));
  CHECK(narrow.edges <= 48);
  CHECK(narrow.filled);
  FillOptions no_limit;
  no_limit.max_diameter = std::numeric_limits<double>::infinity();
  CHECK(gap_of(fill_mesh(floor_with_blade(0.15), no_limit)).filled);
}

TEST_CASE("ConfidenceFallsWithTheWidthTheTurnAtTheRimAndTheRoughnessOfTheRim") {
  CHECK(patch_confidence({.width = 1.5, .rim_angle = 1.0}) > 0.95);
  CHECK(patch_confidence({.width = 15.0, .rim_angle = 0.05}) > 0.9);
  CHECK(patch_confidence({.width = 60.0, .rim_angle = 0.0}) == Approx(kDoubtful));
  CHECK(patch_confidence({.width = 30.0, .rim_angle = 1.5}) < kDoubtful);
  CHECK(patch_confidence({.width = 15.0, .roughness = 1.5}) < kDoubtful);
  CHECK(patch_confidence({.width = 2.0, .roughness = 1.5}) > 0.9);
  CHECK(patch_confidence({.width = 30.0, .rim_angle = std::numbers::pi}) > 0.0);
  // A pane is as right as its rim is flat, whatever its width and the turn.
  CHECK(patch_confidence({.width = 40.0, .rim_angle = 1.5, .roughness = 0.3, .is_pane = true}) >
        0.9);
  CHECK(patch_confidence({.width = 40.0, .rim_angle = 1.5, .roughness = 2.0, .is_pane = true}) <
        kDoubtful);
}

namespace {

/// The square of side 1 in `cells` cells a side, and on it a box. Neither the front of the box nor
/// the floor before it was seen, a quarter of the square wide and deep.
TriangleMesh floor_with_shadow(std::uint32_t cells, double height = 0.1) {
  const double step = 1.0 / cells;
  TriangleMesh floor = test::square_mesh(cells);
  cut(floor,
      [&](Vec3 p) { return std::abs(p.y - 0.5) < 0.1375 && p.x - 0.5 > -0.275 && p.x < 0.5; });
  return moved(std::move(floor), [&](Vec3 p) {
    const bool is_on_box =
        std::abs(p.y - 0.5) < 0.1375 - 0.5 * step && p.x > 0.5 - 0.5 * step && p.x < 0.75;
    return is_on_box ? p + Vec3{0.0, 0.0, height} : p;
  });
}

/// The shadow that floor_with_shadow() leaves open, among the loops of what became of it.
const HoleFacts& shadow_of(const FilledMesh& filled) {
  const auto shadow =
      std::find_if(filled.holes.begin(), filled.holes.end(),
                   [](const HoleFacts& h) { return h.open != OpenReason::kOuterBorder; });
  REQUIRE(shadow != filled.holes.end());
  return *shadow;
}

}  // namespace

TEST_CASE("APatchInTheShadowOfABoxIsTrustedLessThanAPaneOfTheSameWidth") {
  // What joins the floor to the lid is a ramp, where the truth is the floor and a wall.
  constexpr double kStep = 1.0 / 80.0;
  const TriangleMesh floor = floor_with_shadow(80);
  FillOptions all;
  all.max_diameter = std::numeric_limits<double>::infinity();
  const FilledMesh filled = fill_mesh(floor, all);
  const auto shadow = std::find_if(filled.holes.begin(), filled.holes.end(),
                                   [](const HoleFacts& hole) { return hole.filled; });
  REQUIRE(shadow != filled.holes.end());
  REQUIRE(shadow->points_added > 100);
  const auto off_truth = [&](Vec3 p) { return std::min(std::abs(p.z), std::abs(p.x - 0.5)); };
  CHECK(farthest_new_vertex(floor, filled, off_truth) > 2.0 * kStep);
  CHECK(shadow->confidence < kDoubtful);
}

TEST_CASE("AWideShadowInAnOpenSceneIsNotClosedByAGuess") {
  const std::uint32_t cells = GENERATE(140, 80);
  CAPTURE(cells);
  const TriangleMesh floor = floor_with_shadow(cells);  // 38 and 22 edges wide and deep
  const FilledMesh left_open = fill_mesh(floor, {});
  const auto shadow =
      std::find_if(left_open.holes.begin(), left_open.holes.end(),
                   [](const HoleFacts& h) { return h.open != OpenReason::kOuterBorder; });
  REQUIRE(shadow != left_open.holes.end());
  CHECK_FALSE(shadow->filled);
  CHECK(shadow->open == OpenReason::kTooWide);
  CHECK(shadow->reason.find("guess") != std::string::npos);
  FillOptions all;
  all.max_diameter = std::numeric_limits<double>::infinity();
  const FilledMesh closed = fill_mesh(floor, all);
  const HoleFacts& patch = closed.holes.at(static_cast<std::size_t>(shadow->id - 1));
  CHECK(patch.filled);
  CHECK(patch.confidence < kDoubtful);
}

TEST_CASE("AGuessOfEightEdgesIsTakenOnlyWhereTheRimIsThatOfAnOpeningInAWall") {
  // 14 edges wide and deep. The ramp to the lid of a high box leaves the floor steeply; that to the
  // lid of a low one stays near it.
  FillOptions all;
  all.max_diameter = std::numeric_limits<double>::infinity();
  for (const double height : {0.1, 0.3}) {
    CAPTURE(height);
    const TriangleMesh floor = floor_with_shadow(50, height);
    const HoleFacts patch = shadow_of(fill_mesh(floor, all));
    REQUIRE(patch.filled);
    CHECK(patch.edges > 48);
    CHECK(patch.confidence < kDoubtful);
    const HoleFacts shadow = shadow_of(fill_mesh(floor, {}));
    CHECK(shadow.filled == (height < 0.2));
    if (!shadow.filled) CHECK(shadow.reason.find("guess") != std::string::npos);
  }
}

TEST_CASE("ANarrowPatchInASmoothSurfaceIsTrustedAndTheBottomOfABeakerIsNot") {
  TriangleMesh ball = test::sphere_mesh(5);
  cut(ball, [](Vec3 p) { return norm(p - Vec3{0.6, 0.48, 0.64}) < 0.25; });
  CHECK(fill_mesh(ball, {}).holes.at(0).confidence > 0.9);
  FillOptions options;
  options.keep_outer_border = false;
  for (const HoleFacts& hole : fill_mesh(tube(2.0), options).holes)
    CHECK(hole.confidence < kDoubtful);
  options.max_edges = 3;
  for (const HoleFacts& hole : fill_mesh(tube(2.0), options).holes) CHECK(hole.confidence == 0.0);
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
