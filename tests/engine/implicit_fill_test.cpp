#include "engine/holes/implicit/implicit_fill.h"
#include "engine/holes/patch/patch_defect.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "engine/holes/fill_hole.h"
#include "engine/holes/patch/patch_intersections.h"
#include "engine/validation/mesh_facts.h"
#include "tests/engine/hole_problems.h"
#include "tests/support/meshes.h"

using namespace orbweave;
using namespace orbweave::test;

namespace {

HolePatch filled(const HoleProblem& problem) {
  HolePatch patch = implicit_fill(problem, triangles_of_loop(problem));
  REQUIRE(patch.method == FillMethod::kImplicit);
  CHECK(patch_defect(problem, patch) == "");
  CHECK(validate_mesh(pasted(problem, patch)).empty());
  CHECK(count_intersections(problem, patch) == 0);
  for (const Vec3 normal : patch.normals) CHECK(norm(normal) == Approx(1.0));
  CHECK(patch.normals.size() == patch.positions.size());
  return patch;
}

/// The largest |distance(p)| of the patch's new vertices.
template <class Distance>
double largest(const HolePatch& patch, const Distance& distance) {
  double result = 0.0;
  for (const Vec3 p : patch.positions) result = std::max(result, std::abs(distance(p)));
  return result;
}

double mean_edge(const HoleProblem& problem, const HolePatch& patch) {
  const TriangleMesh mesh = pasted(problem, patch);
  double sum = 0.0;
  for (const Triangle& t : patch.triangles) {
    for (int k = 0; k < 3; ++k) {
      sum += norm(mesh.vertices.positions[t[k]] - mesh.vertices.positions[t[(k + 1) % 3]]);
    }
  }
  return sum / (3.0 * static_cast<double>(patch.triangles.size()));
}

TriangleMesh hemisphere(int levels) {
  return without(sphere_mesh(levels), [](Vec3 p) { return p.z > 0.0; });
}

}  // namespace

TEST_CASE("HemisphereClosesToADome") {
  const HoleProblem problem = only_problem_of(hemisphere(4));
  const HolePatch patch = filled(problem);
  CHECK(patch.sites > 0);
  CHECK(largest(patch, [](Vec3 p) { return norm(p) - 1.0; }) < 0.03);
  double top = 0.0;
  for (const Vec3 p : patch.positions) top = std::max(top, p.z);
  CHECK(top == Approx(1.0).margin(0.03));
  for (std::size_t i = 0; i < patch.positions.size(); ++i) {
    CHECK(dot(patch.normals[i], normalized(patch.positions[i])) > 0.99);
  }
  CHECK(rim_spacing(problem) == Approx(mean_edge(problem, patch)).epsilon(0.25));
}

TEST_CASE("CapOfASphereComesBackFromTwoThirds") {
  const TriangleMesh sphere = sphere_mesh(4);
  const auto cut = GENERATE(0.3, 0.6);
  const HoleProblem problem = only_problem_of(without(sphere, [&](Vec3 p) { return p.z > cut; }));
  CHECK(largest(filled(problem), [](Vec3 p) { return norm(p) - 1.0; }) < 0.01);
}

TEST_CASE("EndOfATubeClosesToARoundCap") {
  const HoleProblem problem = only_problem_of(open_tube(32, 12));
  const HolePatch patch = filled(problem);
  double top = 0.0;
  for (const Vec3 p : patch.positions) {
    CHECK(p.z > -0.1);
    CHECK(std::hypot(p.x, p.y) < 1.1);
    top = std::max(top, p.z);
  }
  // At least a shallow dome, at most a long one.
  CHECK(top > 0.3);
  CHECK(top < 2.0);
  CHECK(patch.rim_dihedral_rad == 0.0);  // fill_hole's business
}

TEST_CASE("HoleOverAnEdgeOfACubeStaysNearTheCube") {
  const TriangleMesh shape = without(cube_mesh(20), [](Vec3 p) {
    return norm(p - Vec3{1.0, 1.0, 0.5}) < 0.2;
  });
  const HolePatch patch = filled(only_problem_of(shape));
  // The edge is rounded, no more than a fair surface has to.
  CHECK(largest(patch, [](Vec3 p) { return std::max(p.x, p.y) - 1.0; }) < 0.08);
}

TEST_CASE("PatchTurnsWithItsUnitsAndPlace") {
  const TriangleMesh shape = hemisphere(3);
  const HolePatch patch = filled(only_problem_of(shape));
  for (const double scale : {1e-6, 1e6}) {
    const Vec3 offset = scale > 1.0 ? Vec3{} : Vec3{1.0, 2.0, 3.0} * 1e-3;
    const HoleProblem moved = only_problem_of(transformed(shape, scale, offset));
    const HolePatch other = filled(moved);
    REQUIRE(other.positions.size() > 0);
    CHECK(largest(other, [&](Vec3 p) { return norm(p - offset) / scale - 1.0; }) < 0.06);
    CHECK(std::abs(static_cast<double>(other.positions.size()) -
                   static_cast<double>(patch.positions.size())) <
          0.1 * static_cast<double>(patch.positions.size()) + 3.0);
  }
  // Metres of a national grid: eight digits before the point of a scan at the centimetre.
  const Vec3 utm{500000.0, 5400000.0, 300.0};
  const HolePatch far = filled(only_problem_of(transformed(shape, 0.25, utm)));
  CHECK(largest(far, [&](Vec3 p) { return norm(p - utm) / 0.25 - 1.0; }) < 0.06);
}

TEST_CASE("WithoutNormalsTheThinPlateStands") {
  HoleProblem problem = only_problem_of(hemisphere(3));
  std::fill(problem.normals.begin(), problem.normals.end(), Vec3{});
  const HolePatch patch = filled(problem);
  CHECK(patch.sites == 0);
  CHECK(patch.reason.find("thin plate") != std::string::npos);
  // Tangent to the hemisphere, so a dome all the same, but a low one.
  double top = 0.0;
  for (const Vec3 p : patch.positions) top = std::max(top, p.z);
  CHECK(top > 0.4);
}

TEST_CASE("ValuesStayWithinTheRangeAroundTheHole") {
  HoleProblem problem = only_problem_of(hemisphere(3));
  test::set_values(problem, [](Vec3 p) {
    return std::vector{10.0 + p.x, p.z < -0.5 ? 200.0 : 255.0};
  });
  const HolePatch patch = filled(problem);
  REQUIRE(patch.values.size() == 2 * patch.positions.size());
  for (std::size_t i = 0; i < patch.positions.size(); ++i) {
    CHECK(patch.values[2 * i] == Approx(10.0 + patch.positions[i].x).margin(0.2));
    CHECK(patch.values[2 * i + 1] <= 255.0);
    CHECK(patch.values[2 * i + 1] >= 200.0);
  }
}

TEST_CASE("TooManyPointsAreRefusedBeforeTheyAreMade") {
  const HoleProblem problem = only_problem_of(hemisphere(4));
  PatchOptions options;
  options.max_new_points = 20;
  const HolePatch patch = implicit_fill(problem, triangles_of_loop(problem), options);
  CHECK(patch.method == FillMethod::kNone);
  CHECK(patch.reason == "needs more than 20 new points");
  CHECK(patch.triangles.empty());
}

TEST_CASE("MembraneStaysWithinTheLoopsHull") {
  const HoleProblem problem = only_problem_of(hemisphere(3));
  const HolePatch patch = membrane_fill(problem, triangles_of_loop(problem));
  REQUIRE(patch.method == FillMethod::kDirect);
  CHECK(patch_defect(problem, patch) == "");
  REQUIRE(patch.positions.size() > 10);
  CHECK(largest(patch, [](Vec3 p) { return p.z; }) < 1e-9);
}

TEST_CASE("ImplicitPatchIsBitIdenticalOnRepeat") {
  const HoleProblem problem = only_problem_of(open_tube(24, 8));
  const HolePatch first = implicit_fill(problem, triangles_of_loop(problem)),
                  second = implicit_fill(problem, triangles_of_loop(problem));
  CHECK(first.positions == second.positions);
  CHECK(first.triangles == second.triangles);
  CHECK(first.normals == second.normals);
}
