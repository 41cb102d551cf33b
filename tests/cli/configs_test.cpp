// The job files in configs/: each is run as it stands, with nothing but its files replaced.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "io/clouds/open_point_source.h"
#include "io/meshes/mesh_reader.h"
#include "io/points/point_source.h"
#include "tests/cli/holed_meshes.h"

using Catch::Matchers::Contains;
using nlohmann::json;
using namespace orbweave;
using namespace orbweave::test;

namespace {

PointCloud shape_cloud(const ScratchDirectory& in, const std::string& shape, int points) {
  const auto made =
      run_program({"generate", shape, "--points", std::to_string(points), "-o", "whole.ply"},
                  {.directory = in.path()});
  REQUIRE(made.status == 0);
  PointCloud cloud = read_all(*open_point_source(in / "whole.ply"));
  std::filesystem::remove(in / "whole.ply");
  return cloud;
}

/// Without the points within `radius` of `center`.
PointCloud punched(const PointCloud& cloud, Vec3 center, double radius) {
  PointCloud left;
  left.schema = cloud.schema;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (norm(cloud.positions[i] - center) > radius) left.append(cloud, i);
  return left;
}

/// Every other point to one file, the rest to another: two scans of one surface.
void write_as_two_scans(const ScratchDirectory& in, const PointCloud& cloud) {
  PointCloud scans[2];
  for (PointCloud& scan : scans) scan.schema = cloud.schema;
  for (std::size_t i = 0; i < cloud.size(); ++i) scans[i % 2].append(cloud, i);
  write_cloud(in / "scan-1.ply", scans[0]);
  write_cloud(in / "scan-2.ply", scans[1]);
}

/// Runs a job file on scan-*.ply of the directory, with further assignments, and returns its
/// report.
json report_of_config(const ScratchDirectory& in, const std::string& name,
                      const std::vector<std::string>& assignments = {}) {
  const auto path = [&](const char* file) { return (in / file).string(); };
  std::vector<std::string> words = {"run",        source_path("configs/" + name).string(),
                                    "--set",      "input.files=" + path("scan-*.ply"),
                                    "--set",      "output.mesh=" + path("mesh.ply"),
                                    "--set",      "output.report=" + path("report.json"),
                                    "--set",      "output.picture=" + path("mesh.png"),
                                    "--set",      "run.work_dir=" + path("work"),
                                    "--progress", "none"};
  for (const std::string& assignment : assignments) {
    words.emplace_back("--set");
    words.push_back(assignment);
  }
  const auto run = run_program(words, {.directory = in.path()});
  CAPTURE(run.err);
  REQUIRE(run.status == 0);
  CHECK(run.err.empty());
  CHECK(!std::filesystem::exists(in / "work"));
  CHECK(file_text(in / "mesh.png").substr(1, 3) == "PNG");
  CHECK_THAT(file_text(in / "report.html"), Catch::StartsWith("<!DOCTYPE html>"));
  return json::parse(file_text(in / "report.json"));
}

std::size_t filled_in(const json& report) {
  return static_cast<std::size_t>(
      std::count_if(report["holes"].begin(), report["holes"].end(),
                    [](const json& hole) { return hole["filled"].get<bool>(); }));
}

}  // namespace

TEST_CASE("TheJobFileForAnObjectMakesAClosedMesh", "[costly]") {
  const ScratchDirectory in;
  const PointCloud cloud = shape_cloud(in, "bumpy-torus", 20'000);
  const Vec3 center = cloud.positions[cloud.size() / 3];
  write_as_two_scans(in, punched(cloud, center, 0.25));
  const json report = report_of_config(in, "object.toml");
  CHECK(report["input"]["files"].size() == 2);
  CHECK(report["radii"]["values"].size() == 3);
  CHECK(report["mesh"]["watertight"] == true);
  CHECK(report["mesh"]["euler_characteristic"] == 0);
  CHECK(filled_in(report) >= 1);
  CHECK(filled_in(report) == report["holes"].size());
}

TEST_CASE("TheJobFileForATerrainClosesTheGapsAndLeavesTheBorder", "[costly]") {
  const ScratchDirectory in;
  PointCloud cloud = shape_cloud(in, "plane", 12'000);
  const Vec3 gaps[] = {{0.3, 0.3, 0.0}, {0.6, 0.55, 0.0}, {0.25, 0.8, 0.0}};
  for (const Vec3 gap : gaps) cloud = punched(cloud, gap, 0.08);
  for (Vec3& p : cloud.positions) {
    p.z = 0.05 * std::sin(5.0 * p.x) * std::cos(4.0 * p.y);
    p = p + Vec3{448'262.0, 5'411'934.0, 212.0};  // map coordinates
  }
  write_as_two_scans(in, cloud);
  const json report = report_of_config(in, "terrain.toml");
  CHECK(report["mesh"]["boundary_loops"] == 1);
  CHECK(report["mesh"]["components"] == 1);
  CHECK(report["mesh"]["nonmanifold_edges"] == 0);
  CHECK(filled_in(report) == std::size(gaps));
  REQUIRE(report["holes"].size() == std::size(gaps) + 1);
  for (const json& hole : report["holes"]) {
    if (hole["filled"] == true) continue;
    CHECK(hole["diameter"] > 1.0);
    CHECK_THAT(hole["reason"].get<std::string>(), Contains("fill.keep_outer_border"));
  }
}

TEST_CASE("TheJobFileForALargeScanRunsOnASmallOne", "[costly]") {
  const ScratchDirectory in;
  // Its radius of 0.02 is 1.5 times the spacing of a unit square with that many points.
  write_as_two_scans(in, punched(shape_cloud(in, "plane", 5'600), {0.5, 0.5, 0.0}, 0.1));
  const json report = report_of_config(in, "large-scan.toml");
  CHECK(report["radii"]["values"] == json({0.02}));
  CHECK(report["options"]["partition"]["memory"] == std::uint64_t{8} << 30);
  CHECK(report["mesh"]["boundary_loops"] == 1);
  CHECK(filled_in(report) == 1);
}

TEST_CASE("TheJobFileForRawScansMakesOneObjectOfScansWithPoses", "[costly]") {
  const ScratchDirectory in;
  const auto made =
      run_program({"generate", "sphere", "--points", "30000", "--scans", "14", "--noise", "0.4",
                   "--misregistration", "0.6", "--separate", "-o", "scan.ply"},
                  {.directory = in.path()});
  REQUIRE(made.status == 0);
  const json report = report_of_config(in, "raw-scans.toml",
                                       {"input.files=" + (in / "scan_*.ply").string(),
                                        "input.poses=" + (in / "scan.conf").string()});
  CHECK(report["input"]["files"].size() == 14);
  CHECK(report["normals"]["orientation"] == "scanner");
  CHECK(report["cleaning"]["smooth_radius"] > 0.0);
  CHECK(report["mesh"]["components"] == 1);
  CHECK(report["mesh"]["watertight"] == true);
  CHECK(report["mesh"]["euler_characteristic"] == 2);
}

TEST_CASE("TheJobFileForAirborneLidarLooksUpAndKeepsMapCoordinates", "[costly]") {
  const ScratchDirectory in;
  PointCloud cloud = shape_cloud(in, "plane", 8'000);
  cloud.schema.has_normals = false;
  cloud.normals.clear();
  for (Vec3& p : cloud.positions) {
    p.z = 0.05 * std::sin(5.0 * p.x) * std::cos(4.0 * p.y);
    p = p + Vec3{448'262.0, 5'411'934.0, 212.0};
  }
  const Vec3 bird = cloud.positions.front() + Vec3{0.3, 0.3, 0.6};
  cloud.append(PointCloud(cloud), 0);
  cloud.positions.back() = bird;
  write_as_two_scans(in, cloud);
  const json report = report_of_config(in, "airborne-lidar.toml");
  CHECK(report["normals"]["orientation"] == "up");
  CHECK(report["input"]["points_dropped"]["outlier"] >= 1);
  CHECK(report["input"]["points_dropped"]["outlier"] < 20);
  CHECK(report["mesh"]["components"] == 1);
  CHECK(report["mesh"]["boundary_loops"] == 1);
  const PointCloud mesh = read_all(*open_point_source(in / "mesh.ply"));
  CHECK(std::all_of(mesh.normals.begin(), mesh.normals.end(), [](Vec3 n) { return n.z > 0.0; }));
}

TEST_CASE("TheJobFileForATerrestrialScanTurnsTheGroundUpAndClosedThingsOutward", "[costly]") {
  const ScratchDirectory in;
  PointCloud cloud = shape_cloud(in, "torus", 12'000);
  const Box torus = cloud.bounds();
  PointCloud ground = shape_cloud(in, "plane", 12'000);
  const Box plane = ground.bounds();
  const double below = torus.min.z - torus.extent().x;
  for (Vec3& p : ground.positions) {
    const Vec3 place = p - (plane.min + 0.5 * plane.extent());
    p = torus.min + 0.5 * torus.extent() + 1.5 * torus.extent().x / plane.extent().x * place;
    p.z = below;
  }
  cloud.append(ground);
  cloud.schema.has_normals = false;
  cloud.normals.clear();
  write_as_two_scans(in, cloud);
  const json report = report_of_config(in, "terrestrial-scan.toml");
  CHECK(report["normals"]["orientation"] == "ground");
  CHECK(report["normals"]["components"] == 2);
  CHECK(report["normals"]["ground_patches_down"] == 0);
  CHECK(report["mesh"]["boundary_loops"] == 1);  // of the plane
  const TriangleMesh mesh = read_mesh((in / "mesh.ply").string());
  const Vec3 center = torus.min + 0.5 * torus.extent();
  const double core = 0.5 * (torus.extent().x - torus.extent().z);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3 p = mesh.vertices.positions[i];
    const Vec3 flat{p.x - center.x, p.y - center.y, 0.0};
    const bool is_ground = p.z < torus.min.z - 0.1 * torus.extent().x;
    const Vec3 away = is_ground ? Vec3{0.0, 0.0, 1.0} : p - center - core * normalized(flat);
    REQUIRE(dot(mesh.vertices.normals[i], away) > 0.0);
  }
}

TEST_CASE("EveryJobFileOfConfigsIsTestedHere") {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(source_path("configs")))
    names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  CHECK(names == std::vector<std::string>{"airborne-lidar.toml", "large-scan.toml", "object.toml",
                                          "raw-scans.toml", "terrain.toml",
                                          "terrestrial-scan.toml"});
}
