// The whole pipeline on clouds that the tests make: the promises that users rely on.
#include "engine/pipeline/pipeline.h"
#include "engine/planning/plan_job.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <sstream>

#include "engine/validation/mesh_facts.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"

namespace orbweave {
namespace {

using test::bytes_of;
using test::job_for;
using test::mesh_bytes;
using test::NamedCloud;
using test::paint;
using test::painted_torus;
using test::RecordingProgress;
using test::run;
using test::run_with_interruptions;
using test::ScratchDirectory;
using test::shuffle;

ErrorKind status_of(const Job& job) {
  try {
    run(job);
  } catch (const Error& error) {
    UNSCOPED_INFO(error.what());
    return error.kind();
  }
  return ErrorKind::kNone;
}

std::string message_of(const Job& job) {
  try {
    run(job);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("SameBytesForAnyChunkSizeAndThreadCount", "[costly]") {
  const NamedCloud named = painted_torus(6000, 0.4, 3);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  const std::string expected = mesh_bytes(job);
  for (const std::uint64_t chunk_points : {300u, 1500u, 1'000'000'000u}) {
    for (const int threads : {1, 2, 5}) {
      job.partition.chunk_points = chunk_points;
      job.run.threads = threads;
      INFO("chunk_points " << chunk_points << ", threads " << threads);
      REQUIRE((mesh_bytes(job) == expected));
    }
  }
}

TEST_CASE("SameBytesForAnyOrderAndAnySplitOfTheInput", "[costly]") {
  NamedCloud named = painted_torus(8000, 0.4, 5);
  ScratchDirectory scratch;
  const std::string expected = mesh_bytes(job_for(scratch, named));
  for (const std::uint64_t seed : {1u, 2u}) {
    shuffle(named.cloud, seed);
    REQUIRE((mesh_bytes(job_for(scratch, named)) == expected));
  }
  std::vector<std::string> files;
  for (std::size_t part = 0; part < 3; ++part) {
    PointCloud piece;
    piece.schema = named.cloud.schema;
    for (std::size_t i = part; i < named.cloud.size(); i += 3) piece.append(named.cloud, i);
    files.push_back((scratch / ("part" + std::to_string(part) + ".ply")).string());
    write_cloud(files.back(), piece);
  }
  REQUIRE((mesh_bytes(job_for(scratch, named, files)) == expected));
}

TEST_CASE("DuplicatesAndUnusablePointsAreCountedAndChangeNothing") {
  NamedCloud named = painted_torus(4000, 0.2, 7);
  ScratchDirectory scratch;
  const std::string expected = mesh_bytes(job_for(scratch, named));
  const std::size_t points = named.cloud.size();
  for (std::size_t i = 0; i < points; i += 10) named.cloud.append(PointCloud(named.cloud), i);
  const double nan = std::nan("");
  named.cloud.append(PointCloud(named.cloud), 0);
  named.cloud.positions.back().y = nan;
  named.cloud.append(PointCloud(named.cloud), 1);
  named.cloud.normals.back() = {};
  named.cloud.append(PointCloud(named.cloud), 2);
  named.cloud.normals.back().x = INFINITY;
  const Job job = job_for(scratch, named);
  const RunReport report = run(job);
  REQUIRE((bytes_of(job.output.mesh) == expected));
  REQUIRE(report.points_read == named.cloud.size());
  REQUIRE(report.points_dropped.at("exact duplicate") == (points + 9) / 10);
  REQUIRE(report.points_dropped.at("coordinate not finite") == 1);
  REQUIRE(report.points_dropped.at("zero normal") == 1);
  REQUIRE(report.points_dropped.at("normal not finite") == 1);
}

TEST_CASE("ReportedFactsAreThoseOfTheMeshFile", "[costly]") {
  for (const double noise : {0.0, 0.5, 0.9}) {
    const NamedCloud named = painted_torus(3000, noise, 9);
    ScratchDirectory scratch;
    Job job = job_for(scratch, named);
    job.partition.chunk_points = 500;
    job.fill.enabled = false;
    const MeshFacts told = run(job).mesh;
    const TriangleMesh mesh = read_mesh(job.output.mesh);
    REQUIRE(validate_mesh(mesh).empty());
    const MeshFacts measured = mesh_facts(mesh);
    INFO("noise " << noise);
    CHECK(told.vertices == measured.vertices);
    CHECK(told.triangles == measured.triangles);
    CHECK(told.components == measured.components);
    CHECK(told.boundary_edges == measured.boundary_edges);
    CHECK(told.boundary_loops == measured.boundary_loops);
    CHECK(told.nonmanifold_edges == measured.nonmanifold_edges);
    CHECK(told.nonmanifold_vertices == measured.nonmanifold_vertices);
    CHECK(told.euler_characteristic == measured.euler_characteristic);
    CHECK(told.watertight == measured.watertight);
    CHECK(told.checksum == measured.checksum);
    CHECK(told.bounds == measured.bounds);
    CHECK(told.area == Approx(measured.area).epsilon(1e-9));
    CHECK(measured.unreferenced_vertices == 0);
    CHECK(told.watertight == (noise == 0.0));
  }
}

TEST_CASE("AttributesArriveAtTheirOwnVertices") {
  const NamedCloud named = painted_torus(3000, 0.1, 11);
  ScratchDirectory scratch;
  const Job job = job_for(scratch, named);
  run(job);
  PointCloud vertices = read_mesh(job.output.mesh).vertices;
  REQUIRE(vertices.schema.attributes == named.cloud.schema.attributes);
  PointCloud expected = vertices;
  expected.attributes.clear();
  paint(expected);
  REQUIRE(vertices.attributes == expected.attributes);
}

TEST_CASE("InterruptedAnywhereAndResumedGivesTheSameBytes", "[slow]") {
  const NamedCloud named = painted_torus(4000, 0.3, 13);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.partition.chunk_points = 300;
  job.run.threads = 2;
  const std::string expected = mesh_bytes(job);
  std::filesystem::remove(job.output.mesh);
  REQUIRE(run_with_interruptions(job, 1, 7) > 3);
  REQUIRE((bytes_of(job.output.mesh) == expected));
  REQUIRE_FALSE(std::filesystem::exists(job.run.work_dir));
}

TEST_CASE("DamagedResultsAreComputedAgain", "[costly]") {
  const NamedCloud named = painted_torus(3000, 0.3, 17);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.partition.chunk_points = 500;
  const std::string expected = mesh_bytes(job);
  job.run.keep_work_dir = true;
  for (const char* stage : {"points", "mesh"}) {
    run(job);
    const auto victim = std::filesystem::path(job.run.work_dir) / stage / "000002.h5";
    REQUIRE(std::filesystem::exists(victim));
    test::damage(victim);
    INFO(stage);
    REQUIRE((mesh_bytes(job) == expected));
  }
}

TEST_CASE("ChangedRadiiComputeTheMeshAnewButNotThePartition") {
  const NamedCloud named = painted_torus(6000, 0.2, 19);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.run.keep_work_dir = true;
  run(job);
  const auto stages_of = [](const RunReport& report) {
    std::vector<std::string> names;
    for (const StageFacts& stage : report.stages) names.push_back(stage.name);
    return names;
  };
  job.reconstruct.ball_radii = {named.ball_radius};
  const RunReport changed = run(job);
  const std::vector<std::string> names = stages_of(changed);
  REQUIRE(std::find(names.begin(), names.end(), "count") == names.end());
  REQUIRE(std::find(names.begin(), names.end(), "reconstruct") != names.end());
  const std::string bytes = bytes_of(job.output.mesh);
  job.run.fresh = true;
  REQUIRE((mesh_bytes(job) == bytes));
}

TEST_CASE("TheWorkDirectoryKeepsALogOfAllRuns") {
  const NamedCloud named = painted_torus(3000, 0.2, 20);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.run.keep_work_dir = true;
  run(job);
  run(job);
  const std::string log = bytes_of(std::filesystem::path(job.run.work_dir) / "orbweave.log");
  CHECK(log.find("reconstruct: begins") != std::string::npos);
  CHECK(log.find("ball radii ") != std::string::npos);
  CHECK(log.find("resuming") != std::string::npos);
}

TEST_CASE("ChangedInputIsNoticed") {
  NamedCloud named = painted_torus(3000, 0.2, 21);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.run.keep_work_dir = true;
  run(job);
  named.cloud.positions.resize(2000);
  named.cloud.normals.resize(2000);
  named.cloud.attributes.resize(2000 * named.cloud.schema.attribute_bytes());
  write_cloud(job.input.files.front(), named.cloud);
  REQUIRE(run(job).points_read == 2000);
}

TEST_CASE("AutomaticRadiiCloseACleanSurface") {
  const NamedCloud named = painted_torus(10000, 0.05, 23);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.reconstruct.ball_radii.clear();
  const RunReport report = run(job);
  REQUIRE(report.mesh.watertight);
  REQUIRE(report.radii.size() == 1);
  REQUIRE(report.radii_reason.size() > 20);
}

TEST_CASE("WhatCannotBeReconstructedIsBadInputAndLeavesNoFile") {
  ScratchDirectory scratch;
  NamedCloud named = test::grid_sheet(6, 0.0);
  const auto with = [&](std::size_t n, const std::function<Vec3(std::size_t)>& place) {
    named.cloud.positions.clear();
    named.cloud.normals.assign(n, {0, 0, 1});
    for (std::size_t i = 0; i < n; ++i) named.cloud.positions.push_back(place(i));
    Job job = job_for(scratch, named);
    CHECK(status_of(job) == ErrorKind::kBadInput);
    job.reconstruct.ball_radii.clear();
    CHECK(status_of(job) == ErrorKind::kBadInput);
    CHECK_FALSE(std::filesystem::exists(job.output.mesh));
    CHECK_FALSE(std::filesystem::exists(job.run.work_dir));
  };
  with(0, [](std::size_t) { return Vec3{}; });
  with(1, [](std::size_t) { return Vec3{1, 2, 3}; });
  with(2, [](std::size_t i) { return Vec3{double(i), 2, 3}; });
  with(50, [](std::size_t) { return Vec3{1, 2, 3}; });
  with(50, [](std::size_t i) { return Vec3{double(i), double(i), 3}; });
  with(50, [](std::size_t) { return Vec3{std::nan(""), 0, 0}; });
}

TEST_CASE("RadiiFarFromTheSpacingSaySo") {
  const NamedCloud named = painted_torus(4000, 0.0, 25);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.reconstruct.ball_radii = {300.0 * named.ball_radius};
  CHECK(status_of(job) == ErrorKind::kUsage);
  CHECK(message_of(job).find("times the point spacing") != std::string::npos);
  job.reconstruct.ball_radii = {named.ball_radius / 300.0};
  CHECK(status_of(job) == ErrorKind::kBadInput);
  CHECK(message_of(job).find("times the point spacing") != std::string::npos);
  CHECK_FALSE(std::filesystem::exists(job.output.mesh));
}

TEST_CASE("AClosedSurfaceThatFacesInwardIsWarnedOf") {
  NamedCloud named = test::noisy_torus(4000, 0.1, 9);
  for (Vec3& p : named.cloud.positions) p = p + Vec3{5e5, 4e6, 100.0};
  const auto says_inward = [&](std::uint64_t chunk_points) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, named);
    job.partition.chunk_points = chunk_points;
    const RunReport report = run(job);
    return std::any_of(report.warnings.begin(), report.warnings.end(), [](const std::string& line) {
      return line.find("faces inward") != std::string::npos;
    });
  };
  CHECK_FALSE(says_inward(1'000'000));
  for (Vec3& normal : named.cloud.normals) normal = -normal;
  CHECK(says_inward(1'000'000));
  CHECK(says_inward(500));
}

TEST_CASE("AStrayFarFromAPatchedSurfaceMakesItFaceInwardToNobody") {
  NamedCloud named = {"sphere", {}, 0.1};
  PointCloud& sphere = named.cloud;
  sphere.schema.has_normals = true;
  constexpr int kPoints = 3000;
  for (int i = 300; i < kPoints; ++i) {  // a spiral, without its upper end
    const double z = 1.0 - (2.0 * i + 1.0) / kPoints, r = std::sqrt(1.0 - z * z);
    const double angle = 2.399963229728653 * i;
    sphere.positions.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  sphere.normals = sphere.positions;
  sphere.positions.push_back({0, 0, -60});
  sphere.normals.push_back({0, 0, 1});
  const auto says_inward = [&] {
    ScratchDirectory scratch;
    const RunReport report = run(job_for(scratch, named));
    CHECK(report.mesh.watertight);
    CHECK(report.mesh.patch_area > 0.0);
    return std::ranges::any_of(report.warnings, [](const std::string& line) {
      return line.find("faces inward") != std::string::npos;
    });
  };
  CHECK_FALSE(says_inward());
  sphere.positions.pop_back();
  sphere.normals.pop_back();
  for (Vec3& normal : sphere.normals) normal = -normal;
  CHECK(says_inward());
}

TEST_CASE("PlanWritesNothingAndAgreesWithTheRun", "[costly]") {
  const NamedCloud named = painted_torus(9000, 0.1, 27);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.partition.chunk_points = 1000;
  RecordingProgress progress;
  const StopToken stop;
  const JobPlan plan = plan_job(job, progress, stop);
  REQUIRE_FALSE(std::filesystem::exists(job.run.work_dir));
  const RunReport report = run(job);
  CHECK(plan.chunks == report.chunks);
  CHECK(plan.halo_width == report.halo_width);
  CHECK(plan.radii == report.radii);
  CHECK(plan.points == report.points_read);
  CHECK(plan.bounds == report.bounds);
  CHECK(plan.seconds > 0.0);
  CHECK(report.predicted.seconds > 0.0);
  for (const StageFacts& stage : report.stages) CHECK(report.measured.seconds > stage.seconds);
}

TEST_CASE("PointsThatTheRunDropsCountInThePredictedTime", "[costly]") {
  NamedCloud named = painted_torus(4000, 0.3, 28);
  named.cloud.normals.clear();
  named.cloud.schema.has_normals = false;
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.cleaning.outlier_sigma = 4.0;
  job.cleaning.thin_to_spacing = 0.8 * named.ball_radius;
  const double once = run(job).predicted.seconds;
  const PointCloud cloud = named.cloud;
  for (std::size_t i = 0; i < 500; ++i) named.cloud.append(cloud, i);
  ScratchDirectory other;
  Job with_duplicates = job_for(other, named);
  with_duplicates.cleaning = job.cleaning;
  const RunReport report = run(with_duplicates);
  CHECK(report.points_dropped.size() >= 2);
  // They pass through the stages before they are dropped, and through none afterwards.
  CHECK(report.predicted.seconds > 1.02 * once);
  CHECK(report.predicted.seconds < 4500.0 / 4000.0 * once);
}

}  // namespace orbweave
