// Raw scans through the pipeline: poses, estimated normals, their orientation, clean-up.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>

#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/points/cleaning_stage.h"
#include "engine/pipeline/stage/cleaning_rule.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "io/report/progress.h"
#include "partition/octree.h"
#include "tests/io/las_files.h"
#include "tests/support/raw_scans.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;

namespace {

/// Every clean-up stage on, at sizes that fit scans of that spacing.
void clean_everything(Job& job, double spacing) {
  job.cleaning.outlier_sigma = 4.0;
  job.cleaning.merge_tolerance = 0.2 * spacing;
  job.cleaning.smooth_radius = 2.5 * spacing;
  job.cleaning.smooth_passes = 2;
  job.cleaning.thin_to_spacing = 0.8 * spacing;
}

/// How far the torus of the tests (radii 1 and 0.4 about z) is from a point.
double distance_to_torus(Vec3 p) {
  return std::abs(std::hypot(std::hypot(p.x, p.y) - 1.0, p.z) - 0.4);
}

/// Share of triangles that face away from the torus's inside.
double outward_share(const TriangleMesh& mesh) {
  std::size_t outward = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices.positions[t[0]];
    const Vec3 normal = cross(mesh.vertices.positions[t[1]] - a, mesh.vertices.positions[t[2]] - a);
    const Vec3 ring = normalized(Vec3{a.x, a.y, 0.0});
    outward += dot(normal, a - ring) > 0.0 ? 1 : 0;
  }
  return static_cast<double>(outward) / static_cast<double>(mesh.triangles.size());
}

double mean_distance(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const Vec3& p : mesh.vertices.positions) sum += distance_to_torus(p);
  return sum / static_cast<double>(mesh.vertices.size());
}

NamedCloud torus_without_normals(std::size_t points) {
  return without_normals(painted_torus(points, 0.1, 11));
}

std::uint64_t dropped_in_all(const RunReport& report) {
  std::uint64_t sum = 0;
  for (const auto& [reason, count] : report.points_dropped) sum += count;
  return sum;
}

std::string message_of(const Job& job, ErrorKind status) {
  try {
    run(job);
  } catch (const Error& error) {
    CHECK(error.kind() == status);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("RawScansWithEveryCleanUpGiveTheSameBytesForAnyPartition", "[slow]") {
  ScratchDirectory scratch;
  const RawScans scans = scan_torus(scratch, 4000, 0.3, 0.3);
  Job job = job_for(scratch, scans);
  clean_everything(job, scans.spacing);
  const std::string expected = mesh_bytes(job);
  REQUIRE(expected.size() > 20'000);
  for (const std::uint64_t chunk_points : {300u, 1500u, 1'000'000'000u}) {
    for (const int threads : {1, 5}) {
      job.partition.chunk_points = chunk_points;
      job.run.threads = threads;
      INFO("chunk_points " << chunk_points << ", threads " << threads);
      REQUIRE((mesh_bytes(job) == expected));
    }
  }
  std::reverse(job.input.files.begin(), job.input.files.end());
  REQUIRE((mesh_bytes(job) == expected));
}

TEST_CASE("PropagatedNormalsGiveTheSameBytesForAnyPartitionAndOrder", "[slow]") {
  ScratchDirectory scratch;
  NamedCloud named = torus_without_normals(4000);
  Job job = job_for(scratch, named);
  job.normals.orientation = Orientation::kPropagate;
  job.cleaning.outlier_sigma = 4.0;
  job.cleaning.smooth_radius = 3.0 * named.ball_radius;
  job.cleaning.thin_to_spacing = 0.5 * named.ball_radius;
  const std::string expected = mesh_bytes(job);
  for (const std::uint64_t chunk_points : {300u, 2000u, 1'000'000'000u}) {
    job.partition.chunk_points = chunk_points;
    job.run.threads = chunk_points == 2000u ? 5 : 1;
    INFO("chunk_points " << chunk_points);
    REQUIRE((mesh_bytes(job) == expected));
  }
  shuffle(named.cloud, 3);
  write_cloud(job.input.files.front(), named.cloud);
  REQUIRE((mesh_bytes(job) == expected));
}

TEST_CASE("TheGroundGivesTheSameBytesForAnyPartition", "[costly]") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, without_normals(grid_sheet(70, 0.0)));
  job.normals.orientation = Orientation::kGround;
  const RunReport report = run(job);
  CHECK(report.normals.orientation == Orientation::kGround);
  CHECK(report.normals.ground_patches > 4);
  CHECK(report.normals.ground_patches_down == 0);
  const std::string expected = mesh_bytes(job);
  for (const Vec3& n : read_mesh((scratch / "mesh.ply").string()).vertices.normals)
    REQUIRE(n.z > 0.0);
  for (const std::uint64_t chunk_points : {300u, 1500u}) {
    job.partition.chunk_points = chunk_points;
    INFO("chunk_points " << chunk_points);
    REQUIRE((mesh_bytes(job) == expected));
  }
  // Down is where the job says that up is.
  job.normals.up = Vec3{0.0, 0.0, -1.0};
  run(job);
  for (const Vec3& n : read_mesh((scratch / "mesh.ply").string()).vertices.normals)
    REQUIRE(n.z < 0.0);
}

TEST_CASE("ScansWithPosesMakeOneSurfaceThatFacesTheScanners", "[costly]") {
  ScratchDirectory scratch;
  const RawScans scans = scan_torus(scratch, 20'000, 0.0, 0.0);
  Job job = job_for(scratch, scans);
  job.fill.enabled = false;  // what no scan saw is of no interest here
  const RunReport report = run(job);
  CHECK(report.normals.source == NormalSource::kEstimate);
  CHECK(report.normals.orientation == Orientation::kScanner);
  CHECK(report.points_read == dropped_in_all(report) + report.mesh.vertices + report.points_unused);
  const TriangleMesh mesh = read_mesh((scratch / "mesh.ply").string());
  CHECK(outward_share(mesh) > 0.995);
  CHECK(mean_distance(mesh) < 0.05 * scans.spacing);
  CHECK(report.mesh.nonmanifold_edges == 0);
}

TEST_CASE("WithoutAScannerPropagationEndsOutward") {
  ScratchDirectory scratch;
  const RunReport report = run(job_for(scratch, torus_without_normals(6000)));
  CHECK(report.normals.orientation == Orientation::kPropagate);
  CHECK(report.normals.patches > 4);
  CHECK(report.normals.components == 1);
  CHECK(report.mesh.watertight);
  CHECK(report.mesh.euler_characteristic == 0);
  CHECK(outward_share(read_mesh((scratch / "mesh.ply").string())) == 1.0);
}

TEST_CASE("AViewpointAndAnUpDirectionDecideTheSide") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, without_normals(grid_sheet(40, 0.0)));
  const auto mean_z = [&] {
    run(job);
    const TriangleMesh mesh = read_mesh((scratch / "mesh.ply").string());
    double sum = 0.0;
    for (const Vec3& n : mesh.vertices.normals) sum += n.z;
    return sum / static_cast<double>(mesh.vertices.size());
  };
  for (const double side : {1.0, -1.0}) {
    job.normals = {};
    job.normals.up = Vec3{0.0, 0.0, side};
    CHECK(mean_z() == Approx(side));
    job.normals = {};
    job.normals.viewpoint = Vec3{0.3, 0.2, 1000.0 * side};
    CHECK(mean_z() == Approx(side));
  }
}

TEST_CASE("ThickLayersAreCleanedOnlyOnRequestAndSaidSo", "[slow]") {
  ScratchDirectory scratch;
  const RawScans scans = scan_torus(scratch, 20'000, 0.8, 1.0);
  Job job = job_for(scratch, scans);
  RecordingProgress progress;
  const StopToken stop;
  const RunReport raw = run_job(job, {"test"}, progress, stop);
  CHECK(std::any_of(progress.lines.begin(), progress.lines.end(), [](const std::string& line) {
    return line.find("cleaning.auto = true") != std::string::npos;
  }));
  CHECK(raw.cleaning.points_moved == 0);
  const double raw_distance = mean_distance(read_mesh(job.output.mesh));
  job.cleaning.automatic = true;
  const RunReport clean = run(job);
  CHECK(clean.cleaning.thickness > 0.2 * clean.cleaning.spacing);
  CHECK(clean.cleaning.options.smooth_radius > 0.0);
  CHECK(10 * clean.cleaning.points_moved > 9 * clean.mesh.vertices);
  CHECK(clean.mesh.boundary_edges * 5 < raw.mesh.boundary_edges + 5);
  CHECK(mean_distance(read_mesh(job.output.mesh)) < 0.7 * raw_distance);
}

TEST_CASE("MovesOfTheSmoothingAreTheSameInAnyCut") {
  const ScratchDirectory scratch;
  Job job = test::cleaning_job(scratch, 2500);
  const RunReport in_many = run(job);
  job.partition.chunk_points = 1'000'000;
  job.run.work_dir += ".whole";
  const RunReport whole = run(job);
  CHECK(whole.chunks == 1);
  CHECK(in_many.chunks > 3);
  CHECK(whole.cleaning.points_moved > 0);
  CHECK(in_many.cleaning.points_moved == whole.cleaning.points_moved);
  CHECK(in_many.cleaning.mean_move == Approx(whole.cleaning.mean_move));
}

TEST_CASE("CleanScansStayAsTheyAreWhenTheCleanUpIsAutomatic") {
  ScratchDirectory scratch;
  const NamedCloud named = painted_torus(6000, 0.0, 2);
  Job job = job_for(scratch, named);
  const std::string expected = mesh_bytes(job);
  job.cleaning.automatic = true;
  CHECK((mesh_bytes(job) == expected));
}

TEST_CASE("InterruptedRawScansResumeWithTheSameBytes", "[costly]") {
  ScratchDirectory scratch;
  const RawScans scans = scan_torus(scratch, 4000, 0.3, 0.3);
  Job job = job_for(scratch, scans);
  clean_everything(job, scans.spacing);
  job.partition.chunk_points = 800;
  job.run.threads = 2;
  const std::string expected = mesh_bytes(job);
  std::filesystem::remove(job.output.mesh);
  CHECK(run_with_interruptions(job, 5, 15) > 4);
  CHECK((bytes_of(job.output.mesh) == expected));
  CHECK(!std::filesystem::exists(job.run.work_dir));
}

TEST_CASE("MapCoordinatesStayExact") {
  ScratchDirectory scratch;
  NamedCloud named = torus_without_normals(4000);
  const Vec3 place{448'262.25, 5'411'934.5, 212.125};
  for (Vec3& p : named.cloud.positions) {
    // Multiples of 2^-20, so that the sum below is exact.
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = std::ldexp(std::rint(std::ldexp(p[axis], 20)), -20);
  }
  const Job job = job_for(scratch, named);
  run(job);
  TriangleMesh here = read_mesh(job.output.mesh);
  for (Vec3& p : named.cloud.positions) p = p + place;
  write_cloud(job.input.files.front(), named.cloud);
  run(job);
  const TriangleMesh there = read_mesh(job.output.mesh);
  auto expected = named.cloud.positions;
  std::size_t found = 0;
  const auto before = [](Vec3 a, Vec3 b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  };
  std::sort(expected.begin(), expected.end(), before);
  for (const Vec3& p : there.vertices.positions)
    found += std::binary_search(expected.begin(), expected.end(), p, before) ? 1 : 0;
  CHECK(found == expected.size());
  CHECK(there.vertices.size() == here.vertices.size());
  CHECK(there.triangles.size() == here.triangles.size());
}

TEST_CASE("ALasTileKeepsItsDigitsAndItsCoordinateSystem") {
  ScratchDirectory scratch;
  const std::string system = "PROJCS[\"somewhere\",UNIT[\"foot\",0.3048]]";
  LasFile tile{.minor = 4, .format = 6};
  tile.global_encoding = 16;  // the coordinate system is WKT
  tile.variable_records = {variable_record("LASF_Projection", 2112, system)};
  tile.scale = {0.001, 0.001, 0.001};
  tile.offset = {448'000.0, 5'411'000.0, 200.0};
  Random random(8);
  for (int i = 0; i < 900; ++i) {
    LasPoint point;
    point.xyz = {1000 * (i % 30) + static_cast<int>(random.below(200)),
                 1000 * (i / 30) + static_cast<int>(random.below(200)),
                 static_cast<int>(random.below(300))};
    point.return_number = point.number_of_returns = 1;
    point.classification = 2;
    tile.add(point);
  }
  std::ofstream(scratch / "tile.las", std::ios::binary) << tile.bytes();
  Job job;
  job.input.files = {(scratch / "tile.las").string()};
  job.input.las_classes = {2};
  job.normals.up = Vec3{0.0, 0.0, 1.0};
  job.output.mesh = (scratch / "terrain.ply").string();
  const RunReport report = run(job);
  CHECK(report.coordinate_system == system);
  CHECK(report.meters_per_unit == Vec3{0.3048, 0.3048, 0.3048});
  CHECK(bytes_of(scratch / "terrain.prj") == system + "\n");
  CHECK(report.normals.orientation == Orientation::kUp);
  const PointCloud points = read_all(*open_point_source(scratch / "tile.las"));
  const PointCloud vertices = read_all(*open_point_source(job.output.mesh));
  CHECK(vertices.size() == 900);
  CHECK(vertices.schema.attributes == points.schema.attributes);
  std::size_t found = 0;
  for (const Vec3& v : vertices.positions)
    found +=
        std::find(points.positions.begin(), points.positions.end(), v) != points.positions.end()
            ? 1
            : 0;
  CHECK(found == 900);
}

TEST_CASE("ClassesAndReturnsFilterAndAreCounted") {
  ScratchDirectory scratch;
  NamedCloud named = painted_torus(4000, 0.0, 3);
  named.cloud.schema.attributes = {{"classification", ScalarType::kUint8},
                                   {"return_number", ScalarType::kUint8},
                                   {"number_of_returns", ScalarType::kUint8}};
  named.cloud.attributes.clear();
  for (std::size_t i = 0; i < named.cloud.size(); ++i)
    for (const int value : {i % 4 == 0 ? 7 : 2, i % 10 == 1 ? 1 : 2, 2})
      named.cloud.attributes.push_back(static_cast<std::byte>(value));
  Job job = job_for(scratch, named);
  job.input.las_classes = {2, 6};
  job.input.returns = ReturnFilter::kLast;
  const RunReport report = run(job);
  CHECK(report.points_read == named.cloud.size());
  CHECK(report.points_dropped.at("class 7 (low point) not selected") ==
        (named.cloud.size() + 3) / 4);
  CHECK(report.points_dropped.at("not a last return") > 0);
  job.input.files = {(scratch / "plain.ply").string()};
  write_cloud(job.input.files.front(), painted_torus(1000, 0.0, 3).cloud);
  CHECK_THAT(message_of(job, ErrorKind::kBadInput),
             Contains("plain.ply") && Contains("no classification"));
}

TEST_CASE("TheForecastKnowsHowFarNormalsOfMergedPointsReach") {
  const NamedCloud named = torus_without_normals(200'000);
  CountGrid grid;
  grid.add(named.cloud.positions);
  const RootCube root = root_cube(grid.bounds());
  grid.settle(root.side);
  Partition scans;
  scans.octree = cut_octree(grid, root, 20'000);
  scans.spacing = 0.01;
  scans.normal_radius = 0.04;
  ResolvedJob job;
  job.run.threads = 2;
  job.estimates_normals = true;
  const std::vector<double> radii = {0.012};
  CHECK(reach_of_cleaning(job, scans) == 0.04);
  const std::uint64_t alone = predicted_peak_bytes(job, scans, radii);
  job.cleaning.merge_tolerance = 0.3;
  CHECK(reach_of_cleaning(job, scans) == Approx(1.5 * 1.2 * 0.3 * std::sqrt(16.0 / 3.14159265)));
  CHECK(predicted_peak_bytes(job, scans, radii) > alone + alone / 10);
  job.estimates_normals = false;
  CHECK(reach_of_cleaning(job, scans) == 0.04);
}

TEST_CASE("WhatIsMissingForRawScansIsSaid") {
  ScratchDirectory scratch;
  const NamedCloud named = torus_without_normals(500);
  Job job = job_for(scratch, named);
  job.normals.source = NormalSource::kFile;
  CHECK_THAT(message_of(job, ErrorKind::kBadInput), Contains("the cloud has no normals"));
  job.normals.source = NormalSource::kAuto;
  job.normals.orientation = Orientation::kScanner;
  CHECK_THAT(message_of(job, ErrorKind::kBadInput),
             Contains(std::to_string(named.cloud.size()) + " points without a scanner"));
  job.normals.orientation = Orientation::kViewpoint;
  CHECK_THAT(message_of(job, ErrorKind::kUsage), Contains("needs normals.viewpoint"));
  job.normals = {};
  job.cleaning.smooth_radius = 100.0;
  CHECK_THAT(message_of(job, ErrorKind::kUsage), Contains("smooth_radius is far too large"));
  job.cleaning = {};
  job.input.poses = (scratch / "none.conf").string();
  CHECK_THAT(message_of(job, ErrorKind::kBadInput), Contains("cannot open the file of poses"));
  std::ofstream(job.input.poses) << "bmesh other.ply 0 0 0 0 0 0 1\n";
  CHECK_THAT(message_of(job, ErrorKind::kBadInput),
             Contains("no pose for this scan") && Contains("cloud.ply"));
}
