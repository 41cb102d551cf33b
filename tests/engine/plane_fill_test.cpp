#include "engine/holes/plane/plane_fill.h"
#include "engine/holes/patch/patch_defect.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "engine/holes/fill_hole.h"
#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/patch/rim.h"
#include "engine/holes/plane/hole_frame.h"
#include "engine/holes/plane/plane_grid.h"
#include "engine/holes/plane/plane_outline.h"
#include "engine/holes/plane/plane_sites.h"
#include "engine/validation/mesh_facts.h"
#include "tests/engine/hole_problems.h"
#include "tests/support/clouds.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

using test::height_field;
using test::inner_problem_of;
using test::only_problem_of;
using test::Random;
using test::without;

constexpr double kDegree = std::numbers::pi / 180.0;

void check_sound(const HoleProblem& problem, const HolePatch& patch) {
  INFO(patch.reason);
  REQUIRE(patch.method == FillMethod::kPlane);
  CHECK(patch_defect(problem, patch) == "");
  CHECK(count_intersections(problem, patch) == 0);
  REQUIRE(patch.normals.size() == patch.positions.size());
  for (const Vec3 normal : patch.normals) CHECK(norm(normal) == Approx(1.0));
}

std::function<bool(Vec3)> near(Vec3 place, double radius) {
  return [=](Vec3 p) { return norm(p - place) < radius; };
}

Vec3 corner_of(const HoleProblem& problem, const HolePatch& patch, std::uint32_t v) {
  const auto given = static_cast<std::uint32_t>(problem.positions.size());
  return v < given ? problem.positions[v] : patch.positions[v - given];
}

// The largest distance of a new vertex from the truth, in rim spacings.
double worst_distance(const HoleProblem& problem, const HolePatch& patch,
                      const std::function<double(Vec3)>& distance) {
  double worst = 0.0;
  for (const Vec3 p : patch.positions) worst = std::max(worst, std::abs(distance(p)));
  return worst / rim_spacing(problem);
}

struct EdgeLengths {
  double mean = 0.0;
  double longest = 0.0;
  double least_angle = std::numbers::pi;
};
EdgeLengths edge_lengths(const HoleProblem& problem, const HolePatch& patch) {
  EdgeLengths lengths;
  for (const Triangle& t : patch.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = corner_of(problem, patch, t[k]);
      const Vec3 ab = corner_of(problem, patch, t[(k + 1) % 3]) - a;
      const Vec3 ac = corner_of(problem, patch, t[(k + 2) % 3]) - a;
      lengths.mean += norm(ab) / (3.0 * static_cast<double>(patch.triangles.size()));
      lengths.longest = std::max(lengths.longest, norm(ab));
      lengths.least_angle =
          std::min(lengths.least_angle, std::atan2(norm(cross(ab, ac)), dot(ab, ac)));
    }
  }
  return lengths;
}

double saddle(double x, double y) { return 0.4 * (x * x - y * y); }
double waves(double x, double y) { return 0.1 * std::sin(3.0 * x) * std::cos(2.0 * y); }

// A square grid over [-1, 1]^2 with its vertices moved within it.
TriangleMesh uneven_field(std::size_t side, double (*height)(double, double), double noise) {
  Random random(7);
  const double step = 2.0 / static_cast<double>(side);
  return test::moved(height_field(side, height), [&](Vec3 p) {
    const Vec3 q{p.x + 0.3 * step * random.bell(), p.y + 0.3 * step * random.bell(), 0.0};
    return Vec3{q.x, q.y, height(q.x, q.y) + noise * step * random.bell()};
  });
}

}  // namespace

TEST_CASE("HoleInAPlaneIsFilledByThePlane") {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const bool far : {false, true}) {
      INFO("scale " << scale << ", far " << far);
      const Vec3 offset = far ? scale * Vec3{450000.0, 5400000.0, 300.0} : Vec3{};
      const auto tilt = [](double x, double y) { return 0.3 * x - 0.7 * y; };
      const TriangleMesh shape = test::transformed(height_field(30, tilt), scale, offset);
      const HoleProblem problem = inner_problem_of(without(shape, near(offset, 0.4 * scale)));
      const HolePatch patch = plane_fill(problem, {});
      check_sound(problem, patch);
      CHECK(patch.positions.size() > 20);
      const Vec3 normal = normalized(Vec3{-0.3, 0.7, 1.0});
      const double worst =
          worst_distance(problem, patch, [&](Vec3 p) { return dot(p - offset, normal); });
      // Far away coordinates have nine digits less.
      CHECK(worst < (far ? 1e-7 : 1e-12));
      for (const Vec3 n : patch.normals) CHECK(dot(n, normal) > 1.0 - 1e-9);
      CHECK(patch.rim_dihedral_rad < 1e-6);
    }
  }
}

TEST_CASE("PatchFollowsASphere") {
  const TriangleMesh shape = test::sphere_mesh(5);
  const HoleProblem problem = only_problem_of(without(shape, near(normalized(Vec3{1, 2, 3}), 0.3)));
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  CHECK(worst_distance(problem, patch, [](Vec3 p) { return norm(p) - 1.0; }) < 0.03);
  for (std::size_t i = 0; i < patch.positions.size(); ++i) {
    CHECK(dot(patch.normals[i], normalized(patch.positions[i])) > std::cos(1.5 * kDegree));
  }
  CHECK(patch.sites > problem.loop.size());
  CHECK(patch.condition > 1.0);
  CHECK(patch.residual < 0.05 * rim_spacing(problem));
  CHECK(patch.rim_dihedral_rad < 8.0 * kDegree);
}

TEST_CASE("PatchFollowsATorusInsideAndOutside") {
  const TriangleMesh shape = test::torus_mesh(6000);
  const auto distance = [](Vec3 p) { return std::hypot(std::hypot(p.x, p.y) - 1.0, p.z) - 0.4; };
  for (const double place : {0.6, 1.4}) {
    INFO("at x = " << place);
    const HoleProblem problem = only_problem_of(without(shape, near({place, 0, 0}, 0.16)));
    const HolePatch patch = plane_fill(problem, {});
    check_sound(problem, patch);
    CHECK(worst_distance(problem, patch, distance) < 0.1);
  }
}

TEST_CASE("PatchFollowsASaddleWithBothKernels") {
  const HoleProblem problem =
      inner_problem_of(without(uneven_field(40, saddle, 0.0), near({0.1, 0, 0}, 0.35)));
  const auto above = [](Vec3 p) { return p.z - saddle(p.x, p.y); };
  const HolePatch biharmonic = plane_fill(problem, {});
  check_sound(problem, biharmonic);
  CHECK(worst_distance(problem, biharmonic, above) < 0.1);
  PatchOptions options;
  options.kernel = RbfKernel::kTriharmonic;
  const HolePatch triharmonic = plane_fill(problem, options);
  check_sound(problem, triharmonic);
  // A quadratic surface is reproduced.
  CHECK(worst_distance(problem, triharmonic, above) < 1e-3);
}

TEST_CASE("PatchDoesNotDependOnUnitsOrOrigin") {
  const TriangleMesh shape = without(uneven_field(30, waves, 0.0), near({0, 0, 0}, 0.4));
  const HoleProblem problem = inner_problem_of(shape);
  const HolePatch patch = plane_fill(problem, {});
  for (const double scale : {1e-6, 1e6}) {
    const Vec3 offset = scale * Vec3{450000.0, 5400000.0, 300.0};
    const HoleProblem moved = inner_problem_of(test::transformed(shape, scale, offset));
    const HolePatch there = plane_fill(moved, {});
    check_sound(moved, there);
    REQUIRE(there.positions.size() == patch.positions.size());
    for (std::size_t i = 0; i < patch.positions.size(); ++i) {
      CHECK(norm((there.positions[i] - offset) / scale - patch.positions[i]) < 1e-6);
    }
  }
}

TEST_CASE("NewPointsLieAtTheRimsSpacing") {
  const HoleProblem problem =
      inner_problem_of(without(uneven_field(50, waves, 0.0), near({0, 0, 0}, 0.5)));
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  const EdgeLengths lengths = edge_lengths(problem, patch);
  const double spacing = rim_spacing(problem);
  CHECK(lengths.mean > 0.8 * spacing);
  CHECK(lengths.mean < 1.25 * spacing);
  CHECK(lengths.longest < 2.2 * spacing);
  CHECK(lengths.least_angle > 8.0 * kDegree);
}

TEST_CASE("FarFromTheRimTrianglesGrowAndNewPointsLieAllOver") {
  // 64 spacings from its middle to its rim.
  const HoleProblem problem =
      inner_problem_of(without(uneven_field(160, waves, 0.0), near({0, 0, 0}, 0.8)));
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  CHECK(edge_lengths(problem, patch).longest < 6.0 * rim_spacing(problem));
  PatchOptions uniform;
  uniform.graded = false;
  CHECK(patch.positions.size() < plane_fill(problem, uniform).positions.size());
}

TEST_CASE("NewPointsAreDenserWhereTheRimIs") {
  // Columns narrow towards x = 1: to a tenth of their width.
  const auto place = [](double u, double v) {
    return Vec3{1.0 - std::pow(10.0, 1.0 - 2.0 * u) / 10.0, 2.0 * v - 1.0, 0.0};
  };
  TriangleMesh shape = test::grid_mesh(60, 200, false, place);
  const auto gone = [](Vec3 p) { return std::abs(p.y) < 0.4 && p.x > 0.3 && p.x < 0.95; };
  const HoleProblem problem = inner_problem_of(without(shape, gone));
  // The spacing along x falls from about 0.06 to 0.005, along y it is 0.01.
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  double left = 0.0;
  double right = 0.0;
  for (const Vec3 p : patch.positions) (p.x < 0.6 ? left : right) += 1.0;
  CHECK(right / 0.35 > 1.3 * left / 0.3);
}

TEST_CASE("SteepPatchesHaveMorePointsSeenFromAbove") {
  const auto ridge = [](double x, double) { return 2.0 * std::sqrt(0.02 + x * x); };
  const HoleProblem problem = inner_problem_of(without(
      height_field(40, ridge), [](Vec3 p) { return std::abs(p.x) < 0.5 && std::abs(p.y) < 0.3; }));
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  const EdgeLengths lengths = edge_lengths(problem, patch);
  CHECK(lengths.longest < 2.5 * rim_spacing(problem));
  CHECK(lengths.mean < 1.4 * rim_spacing(problem));
}

TEST_CASE("PatchOfANoisyScanIsSmootherThanTheScan") {
  const double noise = 0.4;  // of a column's width
  const HoleProblem problem =
      inner_problem_of(without(uneven_field(40, waves, noise), near({0, 0, 0}, 0.3)));
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  const double step = 2.0 / 40.0;
  double squares = 0.0;
  for (const Vec3 p : patch.positions) squares += std::pow(p.z - waves(p.x, p.y), 2);
  const double rms = std::sqrt(squares / static_cast<double>(patch.positions.size()));
  // The noise itself is a third of its bound.
  CHECK(rms < 0.7 * noise * step / 3.0);
  CHECK(patch.residual > 0.3 * noise * step);
}

TEST_CASE("CleanSurfacesAreInterpolatedExactly") {
  const HoleProblem problem =
      inner_problem_of(without(uneven_field(24, waves, 0.0), near({0, 0, 0}, 0.3)));
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  CHECK(patch.residual < 0.01 * rim_spacing(problem));
}

TEST_CASE("LargeHolesStayWithinTheirSites") {
  PatchOptions options;
  options.max_sites = 250;
  for (const double noise : {0.0, 0.4}) {
    INFO("noise " << noise);
    const HoleProblem problem =
        inner_problem_of(without(uneven_field(100, waves, noise), near({0, 0, 0}, 0.6)));
    const HolePatch patch = plane_fill(problem, options);
    check_sound(problem, patch);
    CHECK(patch.sites <= 250);
    double worst = worst_distance(problem, patch, [](Vec3 p) { return p.z - waves(p.x, p.y); });
    CHECK(worst < (noise > 0.0 ? 1.2 : 1.0));
    CHECK(patch.residual < (noise > 0.0 ? 0.5 : 0.2) * rim_spacing(problem));
  }
}

// A ramp that ends in a wave breaking over the hole.
HoleProblem breaking_wave() {
  const auto place = [](double u, double v) {
    const double s = 4.0 * u - 2.0;
    if (s < 1.0) return Vec3{s, 4.0 * v - 2.0, 0.0};
    const double angle = 3.2 * std::min(s - 1.0, 1.0);  // up, and back over the hole
    return Vec3{1.0 + 0.5 * std::sin(angle), 4.0 * v - 2.0, 0.5 * (1.0 - std::cos(angle))};
  };
  const TriangleMesh shape = test::grid_mesh(80, 80, false, place);
  std::vector<HoleProblem> problems =
      test::problems_of(without(shape, near({0.4, 0, 0}, 0.5)), 4.0);
  REQUIRE(problems.size() == 2);
  const bool second = problems[1].loop.size() < problems[0].loop.size();
  return problems[second ? 1 : 0];
}

TEST_CASE("SheetThatFoldsOverTheHoleShapesNothing") {
  const HoleProblem problem = breaking_wave();
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  CHECK(worst_distance(problem, patch, [](Vec3 p) { return p.z; }) < 0.5);
}

TEST_CASE("SitesEndWhereTheSheetTurnsOver") {
  const HoleProblem problem = breaking_wave();
  REQUIRE(std::any_of(problem.normals.begin(), problem.normals.end(),
                      [](Vec3 n) { return n.z < -0.5; }));
  const Rim rim = find_rim(problem);
  const FrameChoice choice = choose_frame(problem, rim);
  REQUIRE(choice.frame);
  std::vector<Vec3> places;
  for (const Vec3 corner : rim.corners) places.push_back(choice.frame->to_frame(corner));
  const PlaneOutline outline(places, grid_clearance(rim));
  const PlaneSites sites = plane_sites(problem, rim, *choice.frame, outline);
  CHECK(sites.rim == problem.loop.size());
  CHECK(sites.vertices.size() > 2 * problem.loop.size());
  CHECK(sites.vertices.size() < problem.positions.size() / 3);
  for (std::size_t i = 0; i < sites.vertices.size(); ++i) {
    CHECK(problem.normals[sites.vertices[i]].z > 0.2);
    CHECK((i < sites.rim || !outline.contains(sites.places[i])));
  }
}

TEST_CASE("EndOfATubeIsNoHeightField") {
  const HoleProblem problem = only_problem_of(test::open_tube(40, 12));
  const HolePatch patch = plane_fill(problem, {});
  CHECK(patch.method == FillMethod::kNone);
  CHECK(patch.reason == "the sheet along the rim is too steep for a height field");
  CHECK(patch.positions.empty());
  CHECK(patch.triangles.empty());
}

TEST_CASE("LoopThatOverlapsItselfFromAboveIsRefused") {
  // A ribbon along a helix of one and a half turns, closed to a loop by an inner way back: flat
  // enough to be upright everywhere.
  HoleProblem problem;
  const int steps = 60;
  for (const double radius : {1.0, 0.8}) {
    for (int i = 0; i < steps; ++i) {
      const double angle = 3.0 * std::numbers::pi * i / (steps - 1);
      problem.positions.push_back(
          {radius * std::cos(angle), radius * std::sin(angle), 0.01 * angle});
    }
  }
  for (std::uint32_t i = 0; i < steps; ++i) problem.loop.push_back(i);
  for (std::uint32_t i = 2 * steps; i-- > steps;) problem.loop.push_back(i);
  problem.normals.assign(problem.positions.size(), {0, 0, 1});
  const HolePatch patch = plane_fill(problem, {});
  CHECK(patch.method == FillMethod::kNone);
  CHECK(patch.reason == "the loop overlaps itself seen along the hole's normal");
}

TEST_CASE("OuterBorderIsRefused") {
  std::vector<HoleProblem> problems = test::problems_of(test::square_mesh(8));
  REQUIRE(problems.size() == 1);
  CHECK(plane_fill(problems[0], {}).method == FillMethod::kNone);
}

TEST_CASE("ForbiddenEdgesAreNotUsed") {
  HoleProblem problem = inner_problem_of(without(height_field(12, waves), near({0, 0, 0}, 0.3)));
  const HolePatch free = plane_fill(problem, {});
  check_sound(problem, free);
  // Forbid all edges between rim vertices that the patch would use inside.
  std::vector<std::uint32_t> rim = problem.loop;
  std::sort(rim.begin(), rim.end());
  const auto on_rim = [&](std::uint32_t v) {
    return std::binary_search(rim.begin(), rim.end(), v);
  };
  for (std::size_t i = 0; i < rim.size(); ++i) {
    for (std::size_t j = i + 1; j < rim.size(); ++j) problem.forbidden.push_back({rim[i], rim[j]});
  }
  std::sort(problem.forbidden.begin(), problem.forbidden.end());
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  std::size_t rim_edges = 0;
  for (const Triangle& t : patch.triangles) {
    for (int k = 0; k < 3; ++k) rim_edges += on_rim(t[k]) && on_rim(t[(k + 1) % 3]) ? 1 : 0;
  }
  CHECK(rim_edges == problem.loop.size());
}

TEST_CASE("LoopThatTouchesItselfIsFilled") {
  // Two holes that share a vertex, as one loop that visits it twice.
  const TriangleMesh shape = height_field(24, waves);
  HoleProblem problem = inner_problem_of(without(shape, near({0.25, 0, 0}, 0.24)));
  // A pinch: the loop goes to the vertex across and back over an edge of its own, a slit.
  const std::uint32_t first = problem.loop[0];
  std::uint32_t next = problem.loop[1];
  const auto slit = static_cast<std::uint32_t>(problem.positions.size());
  const Vec3 inward = 0.5 * (Vec3{0.25, 0, 0} - problem.positions[first]);
  const Vec3 tip = problem.positions[first] + inward;
  problem.positions.push_back({tip.x, tip.y, waves(tip.x, tip.y)});
  problem.normals.push_back({0, 0, 1});
  problem.loop.insert(problem.loop.begin() + 1, {slit, first});
  REQUIRE(problem.loop[3] == next);
  const HolePatch patch = plane_fill(problem, {});
  REQUIRE(patch.method == FillMethod::kPlane);
  CHECK(patch_defect(problem, patch) == "");
  bool uses_tip = false;
  for (const Triangle& t : patch.triangles) {
    uses_tip = uses_tip || std::count(t.begin(), t.end(), slit) > 0;
  }
  CHECK(uses_tip);
}

TEST_CASE("AttributesFollowTheSheetWithinItsRange") {
  HoleProblem problem = inner_problem_of(without(height_field(30, waves), near({0, 0, 0}, 0.4)));
  test::set_values(problem, [](Vec3 p) {
    return std::vector{100.0 + 50.0 * p.x, p.x > 0.0 ? 255.0 : 0.0};  // a spline would overshoot
  });
  const HolePatch patch = plane_fill(problem, {});
  check_sound(problem, patch);
  REQUIRE(patch.values.size() == 2 * patch.positions.size());
  for (std::size_t i = 0; i < patch.positions.size(); ++i) {
    CHECK(patch.values[2 * i] == Approx(100.0 + 50.0 * patch.positions[i].x).margin(1.0));
    CHECK(patch.values[2 * i + 1] >= 0.0);
    CHECK(patch.values[2 * i + 1] <= 255.0);
  }
}

TEST_CASE("TooManyNewPointsAreRefused") {
  const HoleProblem problem =
      inner_problem_of(without(height_field(40, waves), near({0, 0, 0}, 0.5)));
  PatchOptions options;
  options.max_new_points = 50;
  const HolePatch patch = plane_fill(problem, options);
  CHECK(patch.method == FillMethod::kNone);
  CHECK(patch.reason.find("50") != std::string::npos);
}

TEST_CASE("TheSameProblemGivesTheSameBits") {
  const HoleProblem problem =
      inner_problem_of(without(uneven_field(40, waves, 0.2), near({0, 0, 0}, 0.4)));
  const HolePatch a = plane_fill(problem, {});
  const HolePatch b = plane_fill(problem, {});
  CHECK(a.positions == b.positions);
  CHECK(a.normals == b.normals);
  CHECK(a.triangles == b.triangles);
}

TEST_CASE("BrokenProblemsNeverCrash") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const HoleProblem whole =
      inner_problem_of(without(height_field(20, waves), near({0, 0, 0}, 0.3)));
  SECTION("a vertex beside the rim is not finite") {
    HoleProblem problem = whole;
    std::vector<std::uint32_t> rim = problem.loop;
    std::sort(rim.begin(), rim.end());
    for (std::uint32_t v = 0; v < problem.positions.size(); v += 3) {
      if (!std::binary_search(rim.begin(), rim.end(), v)) problem.positions[v].y = nan;
    }
    const HolePatch patch = plane_fill(problem, {});
    for (const Vec3 p : patch.positions) CHECK(is_finite(p));
  }
  SECTION("no sheet at all") {
    HoleProblem problem = whole;
    problem.sheet.clear();
    problem.normals.assign(problem.positions.size(), {});
    const HolePatch patch = plane_fill(problem, {});
    CHECK(patch.method == FillMethod::kPlane);
    CHECK(patch_defect(problem, patch) == "");
  }
  SECTION("all corners at one place") {
    HoleProblem problem = whole;
    for (Vec3& p : problem.positions) p = {1, 2, 3};
    CHECK(plane_fill(problem, {}).method == FillMethod::kNone);
  }
  SECTION("all corners on a line") {
    HoleProblem problem = whole;
    for (Vec3& p : problem.positions) p = {p.x, 2.0 * p.x, 0.0};
    CHECK(plane_fill(problem, {}).method == FillMethod::kNone);
  }
  SECTION("two corners") {
    HoleProblem problem = whole;
    problem.loop.resize(2);
    CHECK(plane_fill(problem, {}).method == FillMethod::kNone);
  }
}

}  // namespace orbweave
