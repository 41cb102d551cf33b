// Jobs whose normals are the directions to the poles of Voronoi cells.
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <string>

#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/planning/plan_job.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"

namespace orbweave {
namespace {

using namespace test;

Job pole_job(const ScratchDirectory& scratch, const NamedCloud& named) {
  Job job = job_for(scratch, named);
  job.normals.source = NormalSource::kPoles;
  return job;
}

/// Above 0: a closed surface faces outward.
double volume_of(const TriangleMesh& mesh) {
  const auto& p = mesh.vertices.positions;
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) sum += dot(p[t[0]], cross(p[t[1]], p[t[2]])) / 6.0;
  return sum;
}

std::string refusal_of(const Job& job, ErrorKind kind) {
  try {
    run(job);
  } catch (const Error& error) {
    CHECK(error.kind() == kind);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("PolesAreNormalsThatBallsPivotBy") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  const RunReport report = run(pole_job(scratch, without_normals(painted_torus(6000, 0.05, 3))));
  CHECK(report.normals.source == NormalSource::kPoles);
  CHECK(report.normals.orientation == Orientation::kPropagate);
  CHECK(report.mesh.watertight);
  CHECK(report.mesh.euler_characteristic == 0);
  CHECK(volume_of(read_mesh((scratch / "mesh.ply").string())) > 0.0);
}

TEST_CASE("PolesTakeThePlaceOfTheScansNormals") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  NamedCloud named = painted_torus(3000, 0.05, 3);
  const std::string expected = mesh_bytes(pole_job(scratch, without_normals(named)));
  for (Vec3& normal : named.cloud.normals) normal = Vec3{0.0, 0.0, 1.0};
  ScratchDirectory other;
  CHECK((mesh_bytes(pole_job(other, named)) == expected));
}

TEST_CASE("PoleNormalsGiveTheSameBytesForAnyPartitionThreadsAndOrder", "[costly]") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  NamedCloud named = without_normals(painted_torus(4000, 0.3, 5));
  Job job = pole_job(scratch, named);
  const std::string expected = mesh_bytes(job);
  for (const std::uint64_t chunk_points : {300u, 2000u}) {
    job.partition.chunk_points = chunk_points;
    job.run.threads = chunk_points == 2000u ? 3 : 1;
    INFO("chunk_points " << chunk_points);
    const RunReport report = run(job);
    CHECK(report.chunks > 1);
    CHECK((bytes_of(job.output.mesh) == expected));
  }
  shuffle(named.cloud, 3);
  write_cloud(job.input.files.front(), named.cloud);
  CHECK((mesh_bytes(job) == expected));
}

TEST_CASE("InterruptedJobsWithPolesResumeToTheSameBytes", "[costly]") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = pole_job(scratch, without_normals(painted_torus(1500, 0.3, 3)));
  job.partition.chunk_points = 400;
  const std::string expected = mesh_bytes(job);
  std::filesystem::remove(job.output.mesh);
  CHECK(run_with_interruptions(job, 1, 5) > 0);
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("PolesBeyondTheBudgetAreRefusedWithTheFigures") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = pole_job(scratch, without_normals(painted_torus(200'000, 0.0, 1)));
  job.run.threads = 1;
  job.partition.memory_bytes = std::uint64_t{256} << 20;
  const auto check_refusal = [](const std::string& message) {
    CHECK_THAT(message, Catch::Matchers::Contains("too small for normals.source = \"poles\"") &&
                            Catch::Matchers::Contains("200,239 points") &&
                            Catch::Matchers::Contains("at least"));
  };
  check_refusal(refusal_of(job, ErrorKind::kResource));
  RecordingProgress progress;
  const StopToken stop;
  try {
    plan_job(job, progress, stop);
    FAIL("the plan takes what the run refuses");
  } catch (const Error& error) {
    check_refusal(error.what());
  }
}

TEST_CASE("PolesOfPointsInOnePlaneAreRefused") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  CHECK_THAT(
      refusal_of(pole_job(scratch, without_normals(grid_sheet(20, 0.0))), ErrorKind::kBadInput),
      Catch::Matchers::Contains("in one plane") &&
          Catch::Matchers::Contains("takes points of one plane"));
}

TEST_CASE("WithoutTheVoronoiFamilyPolesAreRefused") {
  if (has_voronoi_family()) return;
  ScratchDirectory scratch;
  CHECK_THAT(refusal_of(pole_job(scratch, painted_torus(500, 0.0, 1)), ErrorKind::kUsage),
             Catch::Matchers::Contains("without the methods of the Voronoi family"));
}

}  // namespace orbweave
