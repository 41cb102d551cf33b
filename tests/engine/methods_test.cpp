// Jobs with the methods that take the whole cloud at once, and the fans of their triangles.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/planning/plan_job.h"
#include "engine/stitching/triangle_fans.h"
#include "engine/synthetic/synthetic_cloud.h"
#include "engine/validation/mesh_facts.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

using namespace test;

constexpr ReconstructionMethod kMethods[] = {ReconstructionMethod::kCrust,
                                             ReconstructionMethod::kCocone,
                                             ReconstructionMethod::kTightCocone};

std::string message_of(const Job& job) {
  try {
    run(job);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("FansOfTrianglesAreThoseThatBallPivotingFinds") {
  const NamedCloud named = noisy_torus(3000, 0.5, 5);
  const BallPivotingResult found = ball_pivoting(named.cloud.positions, named.cloud.normals, {},
                                                 {.ball_radii = {named.ball_radius}});
  REQUIRE(found.boundary.size() > 5);
  const BallPivotingResult made = with_fans(found.triangles, named.cloud.size());
  CHECK(made.triangles == found.triangles);
  CHECK(made.fans == found.fans);
  CHECK(made.fan_members == found.fan_members);
  auto expected = found.boundary, boundary = made.boundary;
  std::sort(expected.begin(), expected.end());
  std::sort(boundary.begin(), boundary.end());
  CHECK(boundary == expected);
}

TEST_CASE("ComponentsTurnToTheirNormalsOneByOne") {
  const TriangleMesh left = sphere_mesh(2);
  const TriangleMesh right = moved(flipped(left), [](Vec3 p) { return p + Vec3{5.0, 0.0, 0.0}; });
  const TriangleMesh both = joined(left, right);
  std::vector<Vec3> outward;
  for (const Vec3 p : both.vertices.positions)
    outward.push_back(p.x > 2.5 ? p - Vec3{5.0, 0.0, 0.0} : p);
  std::vector<Triangle> triangles;
  for (const Triangle& t : both.triangles) triangles.push_back(smallest_first(t));
  turn_to_normals(both.vertices.positions, outward, triangles);
  for (const Triangle& t : triangles) {
    const auto& p = both.vertices.positions;
    CHECK(dot(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]), outward[t[0]]) > 0.0);
  }
}

TEST_CASE("MethodsThatAreNotThereSaySo") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(500, 0.0, 1));
  job.reconstruct.method = ReconstructionMethod::kPowerCrust;
  const std::string expected =
      has_voronoi_family() ? "not points of the scan" : "without the methods of the Voronoi family";
  CHECK_THAT(message_of(job), Catch::Matchers::Contains(expected));
  job.reconstruct.method = ReconstructionMethod::kCocone;
  if (!has_voronoi_family()) CHECK_THAT(message_of(job), Catch::Matchers::Contains(expected));
}

TEST_CASE("MethodsCloseATorusInAJob") {
  if (!has_voronoi_family()) return;
  for (const ReconstructionMethod method : kMethods) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, painted_torus(3000, 0.1, 3));
    job.reconstruct.method = method;
    const RunReport report = run(job);
    INFO("method " << static_cast<int>(method));
    CHECK(report.chunks == 1);
    CHECK(report.radii.empty());
    CHECK(report.mesh.watertight);
    CHECK(report.mesh.euler_characteristic == 0);
    const TriangleMesh mesh = read_mesh(job.output.mesh);
    CHECK(validate_mesh(mesh).empty());
    CHECK(mesh_facts(mesh).watertight);
    CHECK(mesh_facts(mesh).triangles == report.mesh.triangles);
  }
}

TEST_CASE("MethodsCloseTwoComponentsInAJob") {
  SyntheticOptions options;
  options.shape = Shape::kTwoComponents;
  options.points = 4000;
  SyntheticCloud source(options);
  PointCloud cloud;
  source.read(cloud, options.points);
  const NamedCloud named{"two components", std::move(cloud), 1.3 * spacing(options)};
  for (const ReconstructionMethod method :
       {ReconstructionMethod::kBallPivoting, ReconstructionMethod::kCocone,
        ReconstructionMethod::kTightCocone}) {
    if (is_in_core(method) && !has_voronoi_family()) continue;
    ScratchDirectory scratch;
    Job job = job_for(scratch, named);
    job.reconstruct.method = method;
    const RunReport report = run(job);
    INFO("method " << static_cast<int>(method));
    CHECK(report.mesh.watertight);
    CHECK(report.mesh.components == 2);
    CHECK(report.mesh.euler_characteristic == 2);
    const TriangleMesh mesh = read_mesh(job.output.mesh);
    CHECK(validate_mesh(mesh).empty());
    std::uint64_t on_sphere = 0;
    for (const Vec3 p : mesh.vertices.positions) on_sphere += p.z > 0.6 ? 1 : 0;
    const auto of_sphere = std::ranges::count_if(
        mesh.triangles, [&](const Triangle& t) { return mesh.vertices.positions[t[0]].z > 0.6; });
    CHECK(of_sphere == static_cast<std::ptrdiff_t>(2 * on_sphere - 4));  // Euler number 2, then 0
  }
}

TEST_CASE("MethodsMakeTheSameBytesForAnyOrderThreadsAndChunks") {
  if (!has_voronoi_family()) return;
  NamedCloud named = painted_torus(1500, 0.3, 3);
  for (const ReconstructionMethod method : kMethods) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, named);
    job.reconstruct.method = method;
    const std::string expected = mesh_bytes(job);
    NamedCloud other = named;
    shuffle(other.cloud, 7);
    ScratchDirectory again;
    Job shuffled = job_for(again, other);
    shuffled.reconstruct.method = method;
    shuffled.partition.chunk_points = 300;
    shuffled.run.threads = 1;
    INFO("method " << static_cast<int>(method));
    CHECK((mesh_bytes(shuffled) == expected));
  }
}

TEST_CASE("InterruptedMethodsResumeToTheSameBytes", "[costly]") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(1500, 0.3, 3));
  job.reconstruct.method = ReconstructionMethod::kTightCocone;
  const std::string expected = mesh_bytes(job);
  std::filesystem::remove(job.output.mesh);
  CHECK(run_with_interruptions(job, 1, 3) > 0);
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("AWorkDirectoryOfAnotherMethodIsNotTaken") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(1500, 0.3, 3));
  job.run.keep_work_dir = true;
  const std::string pivoted = mesh_bytes(job);
  job.reconstruct.method = ReconstructionMethod::kTightCocone;
  const std::string tight = mesh_bytes(job);
  CHECK((tight != pivoted));
  CHECK(read_mesh(job.output.mesh).triangles.size() > 0);
  job.reconstruct.method = ReconstructionMethod::kBallPivoting;
  CHECK((mesh_bytes(job) == pivoted));
}

TEST_CASE("TooManyPointsForTheBudgetAreRefusedWithTheFigures") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(200'000, 0.0, 1));
  job.reconstruct.method = ReconstructionMethod::kCrust;
  job.run.threads = 1;
  job.partition.memory_bytes = std::uint64_t{256} << 20;
  const std::string refused = "too small for the method crust";
  CHECK_THAT(message_of(job), Catch::Matchers::Contains(refused) &&
                                  Catch::Matchers::Contains("200,239 points") &&
                                  Catch::Matchers::Contains("at least"));
  RecordingProgress progress;
  const StopToken stop;
  try {
    plan_job(job, progress, stop);
    FAIL("the plan takes what the run refuses");
  } catch (const Error& error) {
    CHECK_THAT(std::string(error.what()), Catch::Matchers::Contains(refused));
  }
}

}  // namespace orbweave
