#include "engine/holes/fill_hole.h"
#include "engine/holes/patch/patch_defect.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "engine/holes/loops/loop_parts.h"
#include "engine/holes/loops/parts_in_scene.h"
#include "engine/holes/patch/direct_fill.h"
#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/patch/untangle.h"
#include "engine/holes/plane/plane_fill.h"
#include "engine/validation/mesh_facts.h"
#include "tests/engine/hole_problems.h"
#include "tests/support/clouds.h"
#include "tests/support/meshes.h"

using namespace orbweave;
using namespace orbweave::test;

namespace {

void check_sound(const HoleProblem& problem, const HolePatch& patch) {
  INFO(name_of(patch.method) << ": " << patch.reason);
  REQUIRE(patch.method != FillMethod::kNone);
  CHECK(patch_defect(problem, patch) == "");
  for (const std::string& line : validate_mesh(pasted(problem, patch))) FAIL_CHECK(line);
  REQUIRE(patch.normals.size() == patch.positions.size());
  for (const Vec3 p : patch.positions) CHECK(is_finite(p));
  for (const Vec3 normal : patch.normals) CHECK(norm(normal) == Approx(1.0));
}

const PatchOptions kCrossingAllowed{.allow_intersections = true};

/// A patch that crosses nothing, with as many open edges as it says, whose vertices have one gap
/// for each corner of the loop.
void check_clear_part(const HoleProblem& problem, const HolePatch& patch) {
  if (patch.method == FillMethod::kNone) {
    CHECK(!patch.reason.empty());
    CHECK(patch.triangles.empty());
    return;
  }
  CHECK(count_intersections(problem, patch) == 0);
  if (patch.open_edges == 0) {
    CHECK(patch_defect(problem, patch) == "");
    return;
  }
  std::set<std::array<std::uint32_t, 2>> rim, edges;
  for (std::size_t i = 0; i < problem.loop.size(); ++i)
    rim.insert({problem.loop[i], problem.loop[(i + 1) % problem.loop.size()]});
  for (const Triangle& t : patch.triangles)
    for (int k = 0; k < 3; ++k) CHECK(edges.insert({t[k], t[(k + 1) % 3]}).second);
  // What is open, in the direction of the loop: it leaves a vertex as often as it arrives.
  std::map<std::uint32_t, int> leaves, arrives;
  std::uint32_t open = 0;
  const auto add_open = [&](std::uint32_t tail, std::uint32_t head) {
    ++leaves[tail];
    ++arrives[head];
    ++open;
  };
  for (const auto& [tail, head] : rim)
    if (!edges.contains({tail, head})) add_open(tail, head);
  for (const auto& [tail, head] : edges)
    if (!edges.contains({head, tail}) && !rim.contains({tail, head})) add_open(head, tail);
  CHECK(open == patch.open_edges);
  CHECK(leaves == arrives);
  for (const auto& [vertex, count] : leaves) {
    const auto corners = std::count(problem.loop.begin(), problem.loop.end(), vertex);
    CHECK(count <= std::max<std::ptrdiff_t>(corners, 1));
  }
}

/// Fills all holes of a closed shape from which something was taken; the result is closed again.
std::vector<HolePatch> fill_all(const TriangleMesh& shape, const PatchOptions& options = {}) {
  TriangleMesh mesh = shape;
  std::vector<HolePatch> patches;
  for (const HoleProblem& problem : problems_of(shape, 1e9)) {
    const HolePatch patch = fill_hole(problem, options);
    check_sound(problem, patch);
    CHECK(count_intersections(problem, patch) == 0);
    // The whole shape was gathered, so only vertices that no triangle uses are left out.
    const auto base = static_cast<std::uint32_t>(mesh.vertices.positions.size());
    std::vector<std::uint32_t> number;
    for (const Vec3 p : problem.positions) {
      const auto at =
          std::find(shape.vertices.positions.begin(), shape.vertices.positions.end(), p);
      number.push_back(static_cast<std::uint32_t>(at - shape.vertices.positions.begin()));
    }
    mesh.vertices.positions.insert(mesh.vertices.positions.end(), patch.positions.begin(),
                                   patch.positions.end());
    for (const Triangle& t : patch.triangles) {
      Triangle moved;
      for (int k = 0; k < 3; ++k) {
        moved[k] = t[k] < number.size() ? number[t[k]]
                                        : base + t[k] - static_cast<std::uint32_t>(number.size());
      }
      mesh.triangles.push_back(moved);
    }
    patches.push_back(patch);
  }
  CHECK(mesh_facts(mesh).watertight);
  return patches;
}

/// A wavy height field, at any spacing.
double waves(double x, double y) { return 0.1 * std::sin(3.0 * x) * std::cos(2.0 * y); }

/// A smooth hole, and a blade of the sheet through one edge of its rim: few triangles of a patch
/// cross the blade.
HoleProblem smooth_hole_with_blade() {
  HoleProblem problem = inner_problem_of(
      without(height_field(20, waves), [](Vec3 p) { return std::hypot(p.x, p.y) < 0.45; }));
  const Vec3 a = problem.positions[problem.loop[3]], b = problem.positions[problem.loop[4]];
  const auto tip = static_cast<std::uint32_t>(problem.positions.size());
  const Vec3 middle = 0.5 * (a + b), outward = 0.02 * normalized(middle);
  for (const Vec3 offset :
       {Vec3{0, 0, 0.2}, Vec3{0, 0, -0.2} - outward, Vec3{0, 0, -0.2} + outward}) {
    problem.positions.push_back(middle + offset);
    problem.normals.push_back({});
  }
  problem.sheet.push_back({tip, tip + 1, tip + 2});
  return problem;
}

/// Two square holes of a grid that meet in a vertex as one loop, and blades of the sheet through
/// one of them.
HoleProblem eight_with_blades(std::size_t quads, int blades) {
  const double side = static_cast<double>(quads) / 32.0;
  const auto is_in = [&](double x, double y) { return x > 0 && x < side && y > 0 && y < side; };
  const TriangleMesh shape = without(height_field(64, waves),
                                     [&](Vec3 p) { return is_in(p.x, p.y) || is_in(-p.x, -p.y); });
  std::vector<HoleProblem> problems = problems_of(shape, 1e9);
  std::erase_if(problems, [&](const auto& each) { return each.loop.size() != 4 * quads; });
  REQUIRE(problems.size() == 2);
  // All of the shape was gathered: both have the same numbers.
  HoleProblem problem = std::move(problems[0]);
  std::vector<std::uint32_t> other = std::move(problems[1].loop);
  const auto shared =
      std::find_first_of(problem.loop.begin(), problem.loop.end(), other.begin(), other.end());
  REQUIRE(shared != problem.loop.end());
  std::rotate(problem.loop.begin(), shared, problem.loop.end());
  std::rotate(other.begin(), std::find(other.begin(), other.end(), problem.loop[0]), other.end());
  problem.loop.insert(problem.loop.end(), other.begin(), other.end());
  problem.forbidden.insert(problem.forbidden.end(), problems[1].forbidden.begin(),
                           problems[1].forbidden.end());
  std::sort(problem.forbidden.begin(), problem.forbidden.end());
  for (int i = 0; i < blades; ++i) {
    const Vec3 foot{side * (0.2 + 0.1 * (i % 7)), side * (0.2 + 0.1 * (i / 7)), 0.0};
    const auto first = static_cast<std::uint32_t>(problem.positions.size());
    for (const Vec3 corner : {Vec3{0, 0, 0.5}, Vec3{0.01, 0, -0.5}, Vec3{0, 0.01, -0.5}}) {
      problem.positions.push_back(foot + corner);
      problem.normals.push_back({});
    }
    problem.sheet.push_back({first, first + 1, first + 2});
  }
  return problem;
}

}  // namespace

TEST_CASE("HolesOfThreeAndFourEdgesGetNoNewPoints") {
  TriangleMesh shape = sphere_mesh(3);
  const Triangle first = shape.triangles[100];
  shape.triangles.erase(shape.triangles.begin() + 100);
  SECTION("three edges") {}
  SECTION("four edges") {
    const auto shares_edge = [&](const Triangle& t) {
      return std::count_if(t.begin(), t.end(), [&](std::uint32_t v) {
               return std::count(first.begin(), first.end(), v) > 0;
             }) == 2;
    };
    shape.triangles.erase(
        std::find_if(shape.triangles.begin(), shape.triangles.end(), shares_edge));
  }
  const std::vector<HolePatch> patches = fill_all(shape);
  REQUIRE(patches.size() == 1);
  CHECK(patches[0].method == FillMethod::kDirect);
  CHECK(patches[0].positions.empty());
  CHECK(patches[0].rim_dihedral_rad < 0.3);
}

TEST_CASE("TriangleThatTheSheetHasAlreadyIsClosedAboutANewVertex") {
  // One triangle alone: its border is its own three edges, the other way round.
  TriangleMesh shape;
  shape.vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  shape.triangles = {{0, 1, 2}};
  const HoleProblem problem = only_problem_of(shape);
  CHECK(fill_hole(problem).method == FillMethod::kNone);  // the patch would lie on the triangle
  const HolePatch patch = fill_hole(problem, kCrossingAllowed);
  check_sound(problem, patch);
  CHECK(patch.positions.size() == 1);
  CHECK(mesh_facts(pasted(problem, patch)).watertight);
}

TEST_CASE("ForbiddenDiagonalsAreNotUsed") {
  // A square hole whose diagonals other triangles have: a tent on either side of it.
  HoleProblem problem;
  problem.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  problem.normals.assign(4, {0, 0, 1});
  problem.loop = {0, 1, 2, 3};
  SECTION("one") {
    problem.forbidden = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {2, 3}};
    const HolePatch patch = fill_hole(problem);
    CHECK(patch_defect(problem, patch) == "");
    CHECK(patch.positions.empty());
    REQUIRE(patch.triangles.size() == 2);
    const std::set<std::uint32_t> first(patch.triangles[0].begin(), patch.triangles[0].end());
    CHECK(first.count(1) == 1);
    CHECK(first.count(3) == 1);
  }
  SECTION("both") {
    problem.forbidden = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    const HolePatch patch = fill_hole(problem);
    CHECK(patch_defect(problem, patch) == "");
    REQUIRE(patch.positions.size() == 1);
    CHECK(patch.positions[0] == Vec3{0.5, 0.5, 0.0});
    CHECK(patch.triangles.size() == 4);
  }
}

TEST_CASE("LargeLoopWithAllChordsForbiddenIsClosedAllTheSame") {
  HoleProblem problem = inner_problem_of(
      without(height_field(20, waves), [](Vec3 p) { return std::hypot(p.x, p.y) < 0.5; }));
  HoleProblem grouped = problem;
  for (const std::uint32_t v : problem.loop) grouped.apart.push_back({v, 0});
  std::sort(grouped.apart.begin(), grouped.apart.end());
  for (const std::uint32_t a : problem.loop) {
    for (const std::uint32_t b : problem.loop) {
      if (a < b) problem.forbidden.push_back({a, b});
    }
  }
  std::sort(problem.forbidden.begin(), problem.forbidden.end());
  problem.forbidden.erase(std::unique(problem.forbidden.begin(), problem.forbidden.end()),
                          problem.forbidden.end());
  check_sound(problem, fill_hole(problem));
  check_sound(problem, direct_fill(problem));
  // A group of vertices forbids what all its pairs do.
  for (const auto& fill : {+[](const HoleProblem& of) { return fill_hole(of); },
                           +[](const HoleProblem& of) { return direct_fill(of); }}) {
    const HolePatch of_pairs = fill(problem), of_group = fill(grouped);
    CHECK(of_group.triangles == of_pairs.triangles);
    CHECK(of_group.positions == of_pairs.positions);
  }
}

TEST_CASE("FigureEightIsClosedAsOneLoop") {
  // Two squares of a grid that meet in a vertex.
  const TriangleMesh shape = without(height_field(16, waves), [](Vec3 p) {
    return (p.x > 0.0 && p.x < 0.375 && p.y > 0.0 && p.y < 0.375) ||
           (p.x < 0.0 && p.x > -0.375 && p.y < 0.0 && p.y > -0.375);
  });
  for (const HoleProblem& problem : problems_of(shape)) {
    if (problem.loop.size() == 64) continue;  // the border
    const HolePatch patch = fill_hole(problem);
    check_sound(problem, patch);
    CHECK(count_intersections(problem, patch) == 0);
    const MeshFacts facts = mesh_facts(pasted(problem, patch));
    CHECK(facts.nonmanifold_edges == 0);
  }
}

TEST_CASE("LoopThatVisitsAVertexTwiceIsClosedByEveryMethod") {
  // The pinched vertex 0 lies in the middle of one loop; no chord may use it twice over.
  HoleProblem problem;
  problem.positions = {{0, 0, 0},     {1, 0.2, 0}, {1, 1, 0},    {0.2, 1, 0},
                       {-1, -0.2, 0}, {-1, -1, 0}, {-0.2, -1, 0}};
  problem.normals.assign(7, {0, 0, 1});
  problem.loop = {0, 1, 2, 3, 0, 4, 5, 6};
  for (std::size_t i = 0; i < 8; ++i) {
    const std::uint32_t a = problem.loop[i], b = problem.loop[(i + 1) % 8];
    problem.forbidden.push_back({std::min(a, b), std::max(a, b)});
  }
  std::sort(problem.forbidden.begin(), problem.forbidden.end());
  const auto close = [&](const HolePatch& patch) {
    REQUIRE(patch.method != FillMethod::kNone);
    CHECK(patch_defect(problem, patch) == "");
  };
  close(fill_hole(problem));
  close(direct_fill(problem));
  const PatchOptions all_direct{.direct_edges = 100};
  close(fill_hole(problem, all_direct));
}

TEST_CASE("LoopsAreTakenApartWhereTheyTouchThemselves") {
  using Loops = std::vector<std::vector<std::uint32_t>>;
  CHECK(simple_parts({0, 1, 2, 3}).empty());
  CHECK(simple_parts({0, 1, 2, 0, 3, 4, 5}) == Loops{{0, 1, 2}, {0, 3, 4, 5}});
  CHECK(simple_parts({0, 1, 2, 3, 4, 2, 5}) == Loops{{2, 3, 4}, {0, 1, 2, 5}});
  CHECK(simple_parts({0, 1, 2, 0, 3, 4, 0, 5, 6}) == Loops{{0, 1, 2}, {0, 3, 4}, {0, 5, 6}});
  // A bridge from 1 to 4 is no place to cut.
  CHECK(simple_parts({0, 1, 4, 5, 6, 4, 1, 2}).empty());
}

TEST_CASE("LoopWhoseDiscWouldMeetTheSheetIsTakenApart") {
  // Two square holes that touch in vertex 0, and a wall of the sheet between them.
  HoleProblem problem;
  problem.positions = {{0, 0, 0},   {1, -1, 0}, {2, 0, 0}, {1, 1, 0},   {-1, 1, 0}, {-2, 0, 0},
                       {-1, -1, 0}, {0, 3, -3}, {0, 3, 3}, {0, -3, -3}, {0, -3, 3}};
  problem.normals.assign(11, {0, 0, 1});
  problem.loop = {0, 1, 2, 3, 0, 4, 5, 6};
  problem.sheet = {{0, 7, 8}, {0, 8, 10}, {0, 10, 9}, {0, 9, 7}};
  for (std::size_t i = 0; i < 8; ++i) {
    const std::uint32_t a = problem.loop[i], b = problem.loop[(i + 1) % 8];
    problem.forbidden.push_back({std::min(a, b), std::max(a, b)});
  }
  std::sort(problem.forbidden.begin(), problem.forbidden.end());
  const HolePatch patch = fill_hole(problem);
  REQUIRE(patch.method != FillMethod::kNone);
  CHECK(patch.reason.find("taken apart") != std::string::npos);
  CHECK(patch_defect(problem, patch) == "");
  CHECK(count_intersections(problem, patch) == 0);
}

TEST_CASE("LongLoopOfASceneThatTouchesItselfIsClosedUnlessMuchStandsInIt") {
  const PatchOptions in_scene{.whole = true, .in_scene = true}, alone{.in_scene = true};
  for (const std::size_t quads : {13, 20}) {
    INFO(8 * quads << " edges");
    const HoleProblem clear = eight_with_blades(quads, 0);
    const HolePatch patch = fill_hole(clear, in_scene), same = fill_hole(clear, alone);
    check_sound(clear, patch);
    CHECK(patch.reason.find("taken apart") != std::string::npos);
    CHECK(patch.open_edges == 0);
    CHECK(patch.triangles == same.triangles);
    CHECK(patch.positions == same.positions);
    const HoleProblem full = eight_with_blades(quads, 49);
    const HolePatch none = fill_hole(full, in_scene);
    CHECK(none.method == FillMethod::kNone);
    CHECK(none.open == OpenReason::kTooWide);
    CHECK(none.reason.find("every patch crosses the surface") != std::string::npos);
  }
}

TEST_CASE("LongLoopThatAFlatPatchMayCloseIsNotGivenUpForWhatOthersMeet") {
  const PatchOptions in_scene{.whole = true, .in_scene = true};
  for (const std::size_t quads : {13, 20}) {
    INFO(8 * quads << " edges");
    const HoleProblem level = eight_with_blades(quads, 49);
    // The sheet falls away steeply all around both squares.
    HoleProblem steep = level;
    const double side = static_cast<double>(quads) / 32.0;
    const auto off = [&](double x, double y) {
      return std::max({0.0, -x, x - side, -y, y - side});
    };
    for (Vec3& p : steep.positions)
      if (std::abs(p.z) < 0.2) p.z = -5.0 * std::min(off(p.x, p.y), off(-p.x, -p.y));
    const auto is_hopeless = [&](const HoleProblem& problem) {
      const BoxTree sheet = BoxTree::of_sheet(problem.positions, problem.sheet);
      return PartsInScene(problem, sheet, in_scene).is_hopeless();
    };
    CHECK(is_hopeless(level));
    CHECK_FALSE(is_hopeless(steep));
  }
}

TEST_CASE("APatchInPartsIsFlatWhereMostOfItsAreaIs") {
  // Two squares of areas 2 and 8 that touch in vertex 0.
  HoleProblem problem;
  problem.positions = {{0, 0, 0},  {1, -1, 0}, {2, 0, 0},  {1, 1, 0},
                       {-2, 2, 0}, {-4, 0, 0}, {-2, -2, 0}};
  problem.normals.assign(7, {0, 0, 1});
  problem.loop = {0, 1, 2, 3, 0, 4, 5, 6};
  const BoxTree sheet = BoxTree::of_sheet(problem.positions, problem.sheet);
  for (const bool is_large_flat : {false, true}) {
    const HolePatch patch =
        fill_by_parts(problem, sheet, [&](const HoleProblem& part, std::size_t) {
          HolePatch of_part = direct_fill(part);
          of_part.is_flat = (area_of(part, of_part) > 4.0) == is_large_flat;
          return of_part;
        });
    REQUIRE(patch.method != FillMethod::kNone);
    CHECK(patch.is_flat == is_large_flat);
  }
}

TEST_CASE("PatchMovesOutOfTheWayOfWhatSticksOut") {
  // A spike of the sheet leans over the hole from its rim, through where the patch would be.
  const TriangleMesh shape =
      without(height_field(20, waves), [](Vec3 p) { return std::hypot(p.x, p.y) < 0.45; });
  HoleProblem problem = inner_problem_of(shape);
  const std::uint32_t foot = problem.loop[3];
  const Vec3 inward = -0.15 * normalized(problem.positions[foot]);
  const auto tip = static_cast<std::uint32_t>(problem.positions.size());
  const Vec3 low{0.0, 0.0, -0.05}, high{0.0, 0.0, 0.05};
  const Vec3 across = 0.02 * cross(inward, Vec3{0.0, 0.0, 1.0});
  for (const Vec3 offset : {inward + high, inward + low + across, inward + low - across}) {
    problem.positions.push_back(problem.positions[foot] + offset);
    problem.normals.push_back({});
  }
  problem.sheet.push_back({tip, tip + 1, tip + 2});
  HolePatch patch = plane_fill(problem, {});
  REQUIRE(patch.method == FillMethod::kPlane);
  const std::uint64_t before = count_intersections(problem, patch);
  REQUIRE(before > 0);
  CHECK(untangle(problem, patch) == 0);
  CHECK(count_intersections(problem, patch) == 0);
  check_sound(problem, patch);
  const HolePatch filled = fill_hole(problem);
  CHECK(filled.method == FillMethod::kPlane);
  CHECK(count_intersections(problem, filled) == 0);
  // The reason does not say of the patch that was taken what was true of one before.
  CHECK(filled.reason == "the first patch that was tried crosses the surface");
}

TEST_CASE("WhatTheLoopsOwnEdgesMeetIsNotSearchedAWayAround") {
  const HoleProblem problem = smooth_hole_with_blade();
  const RimPiercings piercings(problem);
  REQUIRE(piercings.any());
  const HolePatch filled = fill_hole(problem, kCrossingAllowed);
  CHECK(filled.method == FillMethod::kPlane);
  check_sound(problem, filled);
  const std::vector<Contact> contacts = find_contacts(problem, filled);
  REQUIRE_FALSE(contacts.empty());
  CHECK(piercings.count_avoidable(filled, contacts) == 0);
  CHECK(filled.reason.find("every patch crosses the surface, this one") != std::string::npos);
  HolePatch moved = filled;
  CHECK(untangle(problem, moved) == contacts.size());
  CHECK(moved.positions == filled.positions);
}

TEST_CASE("WhereEveryPatchMeetsTheSurfaceTheOptionDecides") {
  // A hexagon with a blade through it.
  HoleProblem problem;
  for (int i = 0; i < 6; ++i) {
    const double angle = i * std::numbers::pi / 3.0;
    problem.positions.push_back({std::cos(angle), std::sin(angle), 0.0});
    problem.loop.push_back(static_cast<std::uint32_t>(i));
  }
  problem.positions.insert(problem.positions.end(), {{0, -0.3, -9}, {0.01, 0.3, -9}, {0, 0, 9}});
  problem.normals.assign(9, {0, 0, 1});
  problem.sheet = {{6, 7, 8}};
  const HolePatch closed = fill_hole(problem, kCrossingAllowed);
  CHECK(closed.method != FillMethod::kNone);
  CHECK(patch_defect(problem, closed) == "");
  CHECK(count_intersections(problem, closed) > 0);
  CHECK(closed.reason.find("every patch crosses the surface, this one") != std::string::npos);
  PatchOptions options;
  options.allow_intersections = false;
  const HolePatch open = fill_hole(problem, options);
  check_clear_part(problem, open);
  CHECK(open.triangles.size() < closed.triangles.size());
  CHECK(open.reason.find("every patch crosses the surface") != std::string::npos);
  SECTION("small loops too") {
    options.direct_edges = 6;
    const HolePatch small = fill_hole(problem, options);
    check_clear_part(problem, small);
    CHECK(small.triangles.size() < 4);
    options.allow_intersections = true;
    CHECK(fill_hole(problem, options).method == FillMethod::kDirect);
  }
}

TEST_CASE("LoopFullOfBladesGetsNoNewPointsAndAFreeOneADome") {
  // The rim of a hemisphere, and blades that stand in it.
  const auto rim_with_blades = [](int blades) {
    HoleProblem problem =
        problems_of(without(sphere_mesh(4), [](Vec3 p) { return p.z > 0.0; }), 1e9).front();
    for (int i = 0; i < blades; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / blades;
      const Vec3 foot{0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.0};
      const auto first = static_cast<std::uint32_t>(problem.positions.size());
      for (const Vec3 corner : {Vec3{0, 0, 2.0}, Vec3{0.01, 0, -0.3}, Vec3{0, 0.01, -0.3}}) {
        problem.positions.push_back(foot + corner);
        problem.normals.push_back({});
      }
      problem.sheet.push_back({first, first + 1, first + 2});
    }
    return problem;
  };
  const HolePatch dome = fill_hole(rim_with_blades(0));
  CHECK(dome.method == FillMethod::kImplicit);
  CHECK(dome.positions.size() > 500);
  const HoleProblem rough = rim_with_blades(80);
  const HolePatch whole = fill_hole(rough, kCrossingAllowed);
  CHECK(whole.method == FillMethod::kDirect);
  CHECK(whole.positions.empty());
  CHECK(patch_defect(rough, whole) == "");
  check_clear_part(rough, fill_hole(rough));
}

TEST_CASE("MonkeySaddleIsFilledInItsPlane") {
  const auto height = [](double x, double y) { return 0.5 * (x * x * x - 3.0 * x * y * y); };
  const HoleProblem problem = inner_problem_of(
      without(height_field(32, height), [](Vec3 p) { return std::hypot(p.x, p.y) < 0.4; }));
  const HolePatch patch = fill_hole(problem);
  check_sound(problem, patch);
  CHECK(patch.method == FillMethod::kPlane);
  for (const Vec3 p : patch.positions) CHECK(p.z == Approx(height(p.x, p.y)).margin(0.01));
}

TEST_CASE("SheetCloseBehindIsNotTouched") {
  // A thin wall: both sides are one piece, the hole is on one of them.
  const double gap = 0.3;
  const TriangleMesh shape = moved(cube_mesh(24), [&](Vec3 p) {
    return Vec3{2.0 * p.x - 1.0, 2.0 * p.y - 1.0, gap * (p.z - 0.5)};
  });
  const TriangleMesh open =
      without(shape, [&](Vec3 p) { return p.z > 0.49 * gap && std::hypot(p.x, p.y) < 0.6; });
  const std::vector<HolePatch> patches = fill_all(open);
  REQUIRE(patches.size() == 1);
  for (const Vec3 p : patches[0].positions) CHECK(p.z == Approx(0.5 * gap).margin(0.01));
}

TEST_CASE("TunnelThroughAWallIsClosedByTwoPatches") {
  const TriangleMesh shape = moved(cube_mesh(24), [](Vec3 p) {
    return Vec3{2.0 * p.x - 1.0, 2.0 * p.y - 1.0, 0.4 * (p.z - 0.5)};
  });
  const TriangleMesh open =
      without(shape, [&](Vec3 p) { return std::abs(p.z) > 0.199 && std::hypot(p.x, p.y) < 0.5; });
  CHECK(fill_all(open).size() == 2);
}

TEST_CASE("EndsOfTubesAndRimsOfHemispheresClose") {
  SECTION("tube") {
    const std::vector<HolePatch> patches = fill_all(open_tube(32, 12));
    REQUIRE(patches.size() == 1);
    CHECK(patches[0].reason.starts_with("flat"));
    for (const Vec3 p : patches[0].positions)
      CHECK(p.z == Approx(patches[0].positions[0].z).margin(1e-9));
  }
  SECTION("hemisphere") {
    const std::vector<HolePatch> patches =
        fill_all(without(sphere_mesh(4), [](Vec3 p) { return p.z > 0.0; }));
    REQUIRE(patches.size() == 1);
    for (const Vec3 p : patches[0].positions) CHECK(norm(p) == Approx(1.0).margin(0.03));
    CHECK(patches[0].rim_dihedral_rad < 0.35);
  }
}

TEST_CASE("HoleOverAnEdgeCloses") {
  const std::vector<HolePatch> patches = fill_all(without(cube_mesh(20), [](Vec3 p) {
    return norm(p - Vec3{1.0, 1.0, 0.5}) < 0.2;
  }));
  REQUIRE(patches.size() == 1);
  const std::vector<HolePatch> corner = fill_all(without(cube_mesh(20), [](Vec3 p) {
    return norm(p - Vec3{1.0, 1.0, 1.0}) < 0.25;
  }));
  REQUIRE(corner.size() == 1);
}

TEST_CASE("HalfATorusCloses") {
  const TriangleMesh whole = torus_mesh(1600);
  SECTION("cut across: two ends of a tube") {
    CHECK(fill_all(without(whole, [](Vec3 p) { return p.y > 0.0; })).size() == 2);
  }
  SECTION("a disc of three eighths of it") {
    const TriangleMesh open = without(
        whole, [](Vec3 p) { return p.y > 0.0 && !(p.z < 0.0 && std::hypot(p.x, p.y) < 1.0); });
    const std::vector<HolePatch> patches = fill_all(open);
    REQUIRE(patches.size() == 1);
    for (const Vec3 p : patches[0].positions) CHECK(norm(p) < 2.0);
  }
}

TEST_CASE("PatchDoesNotDependOnWhereTheLoopBegins") {
  const std::vector<TriangleMesh> shapes = {
      open_tube(16, 6),
      without(sphere_mesh(3), [](Vec3 p) { return p.z > 0.5; }),
      without(cube_mesh(12),
              [](Vec3 p) {
                return norm(p - Vec3{1.0, 1.0, 0.5}) < 0.2;
              }),
  };
  for (const TriangleMesh& shape : shapes) {
    HoleProblem problem = only_problem_of(shape);
    const HolePatch expected = fill_hole(problem);
    for (int turn = 0; turn < 3; ++turn) {
      std::rotate(problem.loop.begin(), problem.loop.begin() + 1, problem.loop.end());
      const HolePatch patch = fill_hole(problem);
      CHECK(patch.positions == expected.positions);
      CHECK(patch.triangles == expected.triangles);
      CHECK(patch.normals == expected.normals);
      CHECK(patch.rim_dihedral_rad == expected.rim_dihedral_rad);
    }
  }
}

TEST_CASE("UnitsAndPlaceDoNotMatter") {
  const std::vector<TriangleMesh> shapes = {
      open_tube(16, 6),
      without(sphere_mesh(3), [](Vec3 p) { return p.z > 0.5; }),
      without(cube_mesh(12),
              [](Vec3 p) {
                return norm(p - Vec3{1.0, 1.0, 0.5}) < 0.2;
              }),
      without(height_field(24, waves), [](Vec3 p) { return std::hypot(p.x, p.y) < 0.3; }),
  };
  for (const TriangleMesh& shape : shapes) {
    const std::size_t holes = problems_of(shape).size();
    const HolePatch expected = fill_hole(problems_of(shape)[holes - 1]);
    const auto check = [&](double scale, Vec3 offset) {
      const std::vector<HoleProblem> problems = problems_of(transformed(shape, scale, offset));
      REQUIRE(problems.size() == holes);
      const HolePatch patch = fill_hole(problems[holes - 1]);
      check_sound(problems[holes - 1], patch);
      CHECK(patch.method == expected.method);
      CHECK(patch.rim_dihedral_rad == Approx(expected.rim_dihedral_rad).margin(0.2));
    };
    check(1e-6, {});
    check(1e6, {});
    check(0x1p-4, {500000.0, 5400000.0, 300.0});
  }
}

TEST_CASE("RandomClosedPolygonsAreClosedSoundlyOrLeftOpenWithAReason") {
  Random random(11);
  for (int round = 0; round < 80; ++round) {
    HoleProblem problem;
    const std::size_t n = 3 + random.below(20);
    for (std::size_t i = 0; i < n; ++i) {
      problem.positions.push_back(random.direction());
      problem.normals.push_back(round % 2 == 0 ? random.direction() : Vec3{});
      problem.loop.push_back(static_cast<std::uint32_t>(i));
      const auto next = static_cast<std::uint32_t>((i + 1) % n);
      problem.forbidden.push_back(
          {std::min(problem.loop.back(), next), std::max(problem.loop.back(), next)});
    }
    // Some vertices are visited again.
    if (n > 8 && round % 3 == 0) problem.loop[5] = problem.loop[1];
    std::sort(problem.forbidden.begin(), problem.forbidden.end());
    const HolePatch patch = fill_hole(problem, kCrossingAllowed);
    if (patch.method == FillMethod::kNone) {
      CHECK(!patch.reason.empty());
      CHECK(patch.triangles.empty());
    } else {
      CHECK(patch_defect(problem, patch) == "");
    }
    check_clear_part(problem, fill_hole(problem));
    const HolePatch direct = direct_fill(problem);
    REQUIRE(direct.method == FillMethod::kDirect);
    CHECK(patch_defect(problem, direct) == "");
  }
}

TEST_CASE("WhatIsNoLoopIsLeftOpenWithAReason") {
  HoleProblem problem;
  problem.positions = {{0, 0, 0}, {1, 0, 0}, {0, std::nan(""), 0}};
  problem.normals.assign(3, {});
  for (const std::vector<std::uint32_t>& loop :
       {std::vector<std::uint32_t>{}, {0}, {0, 1}, {0, 1, 2}, {0, 1, 7}}) {
    problem.loop = loop;
    const HolePatch patch = fill_hole(problem);
    CHECK(patch.method == FillMethod::kNone);
    CHECK(!patch.reason.empty());
  }
}

TEST_CASE("LoopInOnePlaceIsStillClosed") {
  HoleProblem problem;
  problem.positions.assign(6, {1.0, 2.0, 3.0});
  problem.normals.assign(6, {});
  problem.loop = {0, 1, 2, 3, 4, 5};
  const HolePatch patch = fill_hole(problem, kCrossingAllowed);
  CHECK(patch.method == FillMethod::kDirect);
  CHECK(patch_defect(problem, patch) == "");
}

TEST_CASE("WhereABladeCutsAHoleThePatchStopsBesideIt") {
  const HoleProblem problem = smooth_hole_with_blade();
  const HolePatch whole = fill_hole(problem, kCrossingAllowed);
  REQUIRE(count_intersections(problem, whole) > 0);
  const HolePatch part = fill_hole(problem);
  check_clear_part(problem, part);
  REQUIRE(part.method == whole.method);
  CHECK(part.triangles.size() < whole.triangles.size());
  CHECK(part.triangles.size() + 8 > whole.triangles.size());
  CHECK(part.open_edges >= 3);
  CHECK(part.confidence < whole.confidence);
  CHECK(part.reason.find("open along " + std::to_string(part.open_edges) + " edges") !=
        std::string::npos);
}

TEST_CASE("TooManyNewPointsLeaveAHoleOpen") {
  const HoleProblem problem = inner_problem_of(
      without(height_field(40, waves), [](Vec3 p) { return std::hypot(p.x, p.y) < 0.6; }));
  PatchOptions options;
  options.max_new_points = 50;
  const HolePatch patch = fill_hole(problem, options);
  CHECK(patch.method == FillMethod::kNone);
  CHECK(patch.reason.find("50 new points") != std::string::npos);
}

TEST_CASE("SmallHolesOnACurvedSurfaceNeedNoInterpolant") {
  // An interpolant costs a thousand times as much, and most holes are small.
  const TriangleMesh whole = sphere_mesh(3);
  for (std::size_t t = 0; t < whole.triangles.size(); t += 7) {
    TriangleMesh shape = whole;
    shape.triangles.erase(shape.triangles.begin() + static_cast<std::ptrdiff_t>(t));
    const HolePatch patch = fill_hole(only_problem_of(shape));
    REQUIRE(patch.method == FillMethod::kDirect);
    REQUIRE(patch.triangles.size() == 1);
    REQUIRE(patch.positions.empty());
    REQUIRE(patch.sites == 0);
  }
}
