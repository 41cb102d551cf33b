// Holes across edges between planes, held against the truth.
#include "engine/holes/patch/creased_fill.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "engine/holes/fill_hole.h"
#include "engine/holes/implicit/implicit_fill.h"
#include "engine/holes/patch/patch_defect.h"
#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/plane/plane_fill.h"
#include "engine/validation/mesh_facts.h"
#include "tests/engine/hole_problems.h"
#include "tests/support/clouds.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

/// A surface whose distance is known.
struct Shape {
  std::string name;
  std::function<double(double, double)> height;  ///< over [-1, 1]^2
  std::function<double(Vec3)> distance;          ///< signed
  double limit = 0.0;                            ///< of the patch's RMS distance, in spacings
};

constexpr std::size_t kSide = 60;
constexpr double kSpacing = 2.0 / kSide;

/// Two planes that fall from a ridge, which runs aslant, at this angle to the horizon.
Shape ridge(const std::string& name, double slope_deg) {
  const double slope = slope_deg * std::numbers::pi / 180.0;
  const auto across = [](double x, double y) { return std::cos(0.3) * x + std::sin(0.3) * y; };
  return {name, [=](double x, double y) { return -std::tan(slope) * std::abs(across(x, y)); },
          [=](Vec3 p) {
            return (p.z + std::tan(slope) * std::abs(across(p.x, p.y))) * std::cos(slope);
          },
          0.2};
}

/// The corner of a box that stands on its opposite corner.
Shape box_corner() {
  const auto falls = [](double x, double y) {
    double most = -1e300;
    for (const double turn :
         {0.2, 0.2 + 2.0 * std::numbers::pi / 3.0, 0.2 + 4.0 * std::numbers::pi / 3.0})
      most = std::max(most, std::cos(turn) * x + std::sin(turn) * y);
    return most;
  };
  return {"corner of a box", [=](double x, double y) { return -std::numbers::sqrt2 * falls(x, y); },
          [=](Vec3 p) { return (p.z + std::numbers::sqrt2 * falls(p.x, p.y)) / std::sqrt(3.0); },
          0.3};
}

/// The shape without a disc about a place, with noise in spacings.
HoleProblem holed(const Shape& shape, double radius, double noise, Vec3 place = {}) {
  TriangleMesh mesh = test::height_field(kSide, shape.height);
  test::Random random(11);
  for (Vec3& p : mesh.vertices.positions)
    p = p + noise * kSpacing * random.bell() * random.direction();
  return test::inner_problem_of(test::without(std::move(mesh), [&](Vec3 center) {
    const Vec3 away = center - place;
    return std::hypot(away.x, away.y) < radius;
  }));
}

/// RMS of the distances of the patch's faces and new vertices from the truth, in spacings.
double distance_from_truth(const HoleProblem& problem, const HolePatch& patch, const Shape& shape) {
  double squares = 0.0;
  std::size_t count = 0;
  const auto add = [&](Vec3 p) {
    const double away = shape.distance(p) / kSpacing;
    squares += away * away;
    ++count;
  };
  const auto position = [&](std::uint32_t v) {
    const auto given = static_cast<std::uint32_t>(problem.positions.size());
    return v < given ? problem.positions[v] : patch.positions[v - given];
  };
  for (const Triangle& t : patch.triangles)
    add((position(t[0]) + position(t[1]) + position(t[2])) / 3.0);
  for (const Vec3 p : patch.positions) add(p);
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(count, 1)));
}

/// What the hole was filled with before creased patches.
HolePatch smooth_patch(const HoleProblem& problem) {
  HolePatch patch = plane_fill(problem, {});
  if (patch.method != FillMethod::kNone) return patch;
  return implicit_fill(problem, triangles_of_loop(problem), {});
}

void check_sound(const HoleProblem& problem, const HolePatch& patch) {
  CHECK(patch_defect(problem, patch) == "");
  CHECK(count_intersections(problem, patch) == 0);
  for (const std::string& line : validate_mesh(test::pasted(problem, patch))) FAIL_CHECK(line);
  REQUIRE(patch.normals.size() == patch.positions.size());
}

TEST_CASE("HolesAcrossEdgesOfPlanesAreFilledUpToTheEdge") {
  const Shape shape = GENERATE(values<Shape>(
      {ridge("edge of a box", 45.0), ridge("roof", 30.0), ridge("flat roof", 15.0), box_corner()}));
  for (const double radius : {0.15, 0.3, 0.55}) {
    const HoleProblem problem = holed(shape, radius, 0.0, {0.02, -0.03, 0.0});
    const HolePatch patch = fill_hole(problem);
    const double creased = distance_from_truth(problem, patch, shape);
    const double smooth = distance_from_truth(problem, smooth_patch(problem), shape);
    INFO(shape.name << ", radius " << radius / kSpacing << ": " << creased << " spacings, smooth "
                    << smooth << "; " << patch.reason);
    CHECK(patch.method == FillMethod::kCreased);
    CHECK_THAT(patch.reason, Catch::Contains("creased"));
    check_sound(problem, patch);
    CHECK(creased < shape.limit);
    CHECK(creased < 0.5 * smooth);
  }
}

TEST_CASE("NoiseDoesNotHideTheEdge") {
  const Shape shape = GENERATE(values<Shape>({ridge("edge of a box", 45.0), box_corner()}));
  const HoleProblem problem = holed(shape, 0.4, 0.3);
  const HolePatch patch = fill_hole(problem);
  CAPTURE(shape.name, patch.reason);
  CHECK(patch.method == FillMethod::kCreased);
  check_sound(problem, patch);
  CHECK(distance_from_truth(problem, patch, shape) < 0.4);
}

TEST_CASE("TeethOfTheRimDoNotTakeTheEdgeAway") {
  const Shape shape = ridge("acute edge", 60.0);
  test::Random random(5);
  int crossed = 0;  // as they were made
  for (int place = 0; place < 24; ++place) {
    const Vec3 middle{0.2 * random.uniform(), 0.2 * random.uniform(), 0.0};
    const HoleProblem problem = holed(shape, 0.3 + 0.2 * random.uniform(), 0.0, middle);
    const HolePatch patch = fill_hole(problem);
    CAPTURE(place, problem.loop.size(), patch.reason);
    CHECK(patch.method == FillMethod::kCreased);
    check_sound(problem, patch);
    CHECK(distance_from_truth(problem, patch, shape) < 0.1);
    crossed += count_intersections(problem, creased_fill(problem)) > 0 ? 1 : 0;
  }
  CHECK(crossed > 0);  // else nothing was shown
}

TEST_CASE("SmoothSurfacesHaveNoCreasedPatches") {
  const auto nowhere = [](Vec3) { return 0.0; };
  const Shape shape = GENERATE_COPY(values<Shape>(
      {{"plane", [](double x, double) { return 0.3 * x; }, nowhere},
       {"dome", [](double x, double y) { return std::sqrt(4.0 - x * x - y * y); }, nowhere},
       {"saddle", [](double x, double y) { return x * x - y * y; }, nowhere},
       {"cylinder", [](double x, double) { return std::sqrt(1.2 - x * x); }, nowhere},
       {"cone", [](double x, double y) { return -std::hypot(x, y); }, nowhere},
       {"wave", [](double x, double y) { return 0.3 * std::sin(4.0 * x) * std::cos(3.0 * y); },
        nowhere},
       {"fillet", [](double x, double) { return -std::sqrt(x * x + 0.09); }, nowhere}}));
  for (const double radius : {0.15, 0.3, 0.55})
    for (const double noise : {0.0, 0.2}) {
      const HoleProblem problem = holed(shape, radius, noise);
      const HolePatch patch = creased_fill(problem);
      INFO(shape.name << ", radius " << radius << ", noise " << noise << ": " << patch.reason);
      CHECK(patch.method == FillMethod::kNone);
    }
}

TEST_CASE("AHoleBesideAnEdgeIsNoHoleAcrossIt") {
  const HoleProblem problem = holed(ridge("roof", 40.0), 0.25, 0.0, {0.4, 0.0, 0.0});
  CHECK(creased_fill(problem).method == FillMethod::kNone);
  CHECK(fill_hole(problem).method == FillMethod::kPlane);
}

TEST_CASE("ACreasedPatchIsTheSameWhereverTheHoleLies") {
  const HoleProblem problem = holed(ridge("roof", 30.0), 0.3, 0.1);
  HoleProblem turned = problem;
  std::rotate(turned.loop.begin(), turned.loop.begin() + 17, turned.loop.end());
  const HolePatch patch = fill_hole(problem), other = fill_hole(turned);
  CHECK(patch.method == FillMethod::kCreased);
  CHECK(other.triangles == patch.triangles);
  CHECK(std::ranges::equal(other.positions, patch.positions));
  HoleProblem far = problem;
  for (Vec3& p : far.positions) p = 0.25 * p + Vec3{1000.0, -2000.0, 500.0};
  CHECK(fill_hole(far).method == FillMethod::kCreased);
}

TEST_CASE("ValuesOfACreasedPatchLieBetweenThoseOfTheRim") {
  HoleProblem problem = holed(ridge("roof", 30.0), 0.3, 0.0);
  test::set_values(problem, [](Vec3 p) { return std::vector{p.x}; });
  const HolePatch patch = fill_hole(problem);
  REQUIRE(patch.method == FillMethod::kCreased);
  REQUIRE(patch.values.size() == patch.positions.size());
  for (const double value : patch.values) CHECK(std::abs(value) < 0.35);
}

}  // namespace
}  // namespace orbweave
