// Gaps of open scenes: what is closed flat, what stays open as a guess, and what patches are worth.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "engine/holes/fill_mesh.h"
#include "engine/holes/loops/open_scenes.h"
#include "engine/holes/patch/patch_confidence.h"
#include "tests/engine/filled_meshes.h"
#include "tests/support/meshes.h"

namespace orbweave {

using namespace test;

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

TEST_CASE("AWindowWhoseRevealIsRoundedOffIsClosedFlat") {
  // Of a reveal the scan has its edge alone, rounded off: the wall turns away by 30 degrees there.
  // A smooth patch would go on with the turn, by several edges.
  constexpr double kStep = 1.0 / 80.0, kPane = 11.0, kDeep = 0.577 * kStep;
  const auto along = [](double x) { return (x - 0.5) / kStep; };
  const auto from_middle = [&](Vec3 p) {
    return std::max(std::abs(along(p.x)), std::abs(along(p.y)));
  };
  const auto filled_wall = [&](double wave) {
    TriangleMesh wall = test::square_mesh(80);
    cut(wall, [&](Vec3 p) { return from_middle(p) < kPane; });
    wall = moved(std::move(wall), [&](Vec3 p) {
      const double depth = from_middle(p) < kPane + 0.5 ? kDeep : 0.0;
      return p + Vec3{0.0, 0.0, wave * kStep * std::sin(along(p.x)) - depth};
    });
    return std::pair(wall, fill_mesh(wall, {}));
  };
  const auto pane_of = [](const FilledMesh& filled) {
    return *std::find_if(filled.holes.begin(), filled.holes.end(),
                         [](const HoleFacts& hole) { return hole.filled; });
  };
  const auto [wall, filled] = filled_wall(0.0);
  require_sound(wall, filled);
  CHECK_THAT(pane_of(filled).reason, Catch::Contains("turns away all along the rim"));
  CHECK(farthest_new_vertex(wall, filled, [&](Vec3 p) { return std::abs(p.z + kDeep); }) < 1e-9);
  // Where the surface around is no flat wall, such a turn may go on.
  CHECK_THAT(pane_of(filled_wall(0.5).second).reason, !Catch::Contains("turns away"));
  // Faces that lean as much, here into the hole and there out of it, are noise.
  TriangleMesh rough = test::square_mesh(80);
  cut(rough, [&](Vec3 p) { return from_middle(p) < kPane; });
  rough = moved(std::move(rough), [&](Vec3 p) {
    const bool is_up = std::sin(0.5 * std::numbers::pi * (along(p.x) + along(p.y) + 0.5)) > 0.0;
    const double height = from_middle(p) < kPane + 0.5 ? (is_up ? 0.5 : -0.5) * kStep : 0.0;
    return p + Vec3{0.0, 0.0, height};
  });
  CHECK_THAT(pane_of(fill_mesh(rough, {})).reason, !Catch::Contains("turns away"));
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

TEST_CASE("APaneIsClosedBesideWhatStandsInTheWindow") {
  // A window in a wall whose reveal ends at the pane, and a blade that leans from the pane's rim
  // into it. The reveal is seen all around, or its fourth side is not: the scan ends at the wall.
  constexpr double kStep = 1.0 / 80.0, kDepth = 3.0 * kStep, kPane = 11.0;
  const auto along = [](double x) { return (x - 0.5) / kStep; };
  const auto pane_beside_blade = [&](double fourth_side) {
    TriangleMesh wall = test::square_mesh(80);
    cut(wall, [&](Vec3 p) {
      return std::abs(along(p.y)) < kPane && along(p.x) > -kPane && along(p.x) < fourth_side;
    });
    wall = moved(std::move(wall), [&](Vec3 p) {
      const bool is_deep = std::max(std::abs(along(p.x)), std::abs(along(p.y))) < kPane + 0.5;
      return is_deep ? p - Vec3{0.0, 0.0, kDepth} : p;
    });
    std::vector<Vec3>& at = wall.vertices.positions;
    const Vec3 corner{0.5 - kPane * kStep, 0.5, -kDepth};
    const auto foot = static_cast<std::uint32_t>(
        std::min_element(at.begin(), at.end(),
                         [&](Vec3 a, Vec3 b) { return norm(a - corner) < norm(b - corner); }) -
        at.begin());
    const auto first = static_cast<std::uint32_t>(wall.vertices.size());
    const Vec3 far = at[foot] + Vec3{4.0 * kStep, 0.3 * kStep, 0.0}, up{0.0, 0.0, 20.0 * kStep};
    at.push_back(far + up);
    at.push_back(far - up);
    wall.triangles.push_back({foot, first, first + 1});
    const FilledMesh filled = fill_mesh(wall, {});
    CHECK(farthest_new_vertex(wall, filled, [&](Vec3 p) { return std::abs(p.z + kDepth); }) < 1e-9);
    const auto pane =
        std::find_if(filled.holes.begin(), filled.holes.end(),
                     [](const HoleFacts& hole) { return hole.edges > 48 && hole.diameter < 0.5; });
    REQUIRE(pane != filled.holes.end());
    return *pane;
  };
  for (const double fourth_side : {kPane, kPane + 1.0}) {
    CAPTURE(fourth_side);
    const HoleFacts pane = pane_beside_blade(fourth_side);
    CHECK(pane.filled);
    CHECK(pane.open_edges > 0);
    CHECK(4 * pane.open_edges <= pane.edges);
    CHECK(pane.points_added > 100);
    CHECK_THAT(pane.reason, Catch::Contains("where every patch crosses the surface"));
  }
}

TEST_CASE("ConfidenceFallsWithTheWidthTheTurnAtTheRimAndTheRoughnessOfTheRim") {
  CHECK(patch_confidence({.width = 1.5, .rim_angle = 1.0}) > 0.95);
  CHECK(patch_confidence({.width = 15.0, .rim_angle = 0.05}) > 0.9);
  CHECK(patch_confidence({.width = 60.0, .rim_angle = 0.0}) == Approx(kDoubtful));
  CHECK(patch_confidence({.width = 30.0, .rim_angle = 1.5}) < kDoubtful);
  CHECK(patch_confidence({.width = 15.0, .roughness = 1.5}) < kDoubtful);
  CHECK(patch_confidence({.width = 2.0, .roughness = 1.5}) > 0.9);
  CHECK(patch_confidence({.width = 30.0, .rim_angle = std::numbers::pi}) > 0.0);
  // In an object seen from all around nothing else hides.
  CHECK(patch_confidence({.width = 80.0, .rim_angle = 0.0, .in_object = true}) ==
        Approx(kDoubtful));
  CHECK(patch_confidence({.width = 15.0, .roughness = 1.5, .in_object = true}) > 0.9);
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
  const HoleFacts& shadow = shadow_of(left_open);
  CHECK_FALSE(shadow.filled);
  CHECK(shadow.open == OpenReason::kTooWide);
  CHECK(shadow.reason.find("guess") != std::string::npos);
  FillOptions all;
  all.max_diameter = std::numeric_limits<double>::infinity();
  const FilledMesh closed = fill_mesh(floor, all);
  const HoleFacts& patch = closed.holes.at(static_cast<std::size_t>(shadow.id - 1));
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

}  // namespace orbweave
