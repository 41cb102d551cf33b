// One point that is no measurement does not spoil a scan; what cannot be computed with is refused
// by name, and how the work is cut changes neither.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/text/quantity.h"
#include "tests/support/clouds.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

using Catch::Matchers::Contains;
using test::names_in;
using test::ProgramResult;
using test::run_in;
using test::ScratchDirectory;

// All of cli_test: its jobs flush thousands of small files.
[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

constexpr double kNoData = std::numeric_limits<float>::lowest();

std::vector<Vec3> sphere(std::size_t points, double radius, Vec3 center) {
  std::vector<Vec3> positions = test::random_sphere(points, 5).cloud.positions;
  for (Vec3& p : positions) p = center + radius * normalized(p);
  return positions;
}

/// Text, with every digit; normals as of a sphere around `center`.
void write_cloud(const std::filesystem::path& path, const std::vector<Vec3>& points, Vec3 center) {
  std::ofstream file(path);
  for (const Vec3& p : points) {
    const Vec3 n = normalized(p - center);
    for (const double value : {p.x, p.y, p.z}) file << format_exact(value) << ' ';
    // Strays may be so far away that only their direction is a number.
    file << (is_finite(n) && squared_norm(n) > 0.5
                 ? format_exact(n.x) + " " + format_exact(n.y) + " " + format_exact(n.z)
                 : std::string("0 0 1"))
         << '\n';
  }
}

std::vector<std::string> cut_in(std::uint64_t chunk_points, std::vector<std::string> words) {
  words.insert(words.end(), {"--chunk-points", std::to_string(chunk_points)});
  return words;
}

/// The mesh's bytes, the same for all cuts.
std::string mesh_of(const ScratchDirectory& in, const std::string& scan,
                    const std::vector<std::string>& options = {}) {
  std::string bytes;
  for (const std::uint64_t chunk : {100'000u, 1000u, 100u}) {
    std::vector<std::string> words = {"reconstruct", scan, "-o", "mesh.ply"};
    words.insert(words.end(), options.begin(), options.end());
    const ProgramResult result = run_in(in, cut_in(chunk, words));
    INFO(scan << ", chunks of " << chunk << ": " << result.err);
    REQUIRE(result.status == 0);
    const std::string found = test::file_text(in / "mesh.ply");
    if (bytes.empty()) bytes = found;
    CHECK((found == bytes));
  }
  CHECK(!bytes.empty());
  return bytes;
}

struct Placed {
  std::string name;
  double radius;
  Vec3 center;
  std::vector<Vec3> strays;
  std::string reason;
};

}  // namespace

TEST_CASE("TheFileIsTheOneWithoutStraysAndTheyAreNamedAndCounted", "[slow]") {
  const ScratchDirectory in;
  const std::vector<Placed> clouds = {
      {"one at 1e7", 0.3, {0.7, 0.3, 0.1}, {{1e7, 0, 0}}, "stray"},
      {"the origin far from a map", 5.0, {500'000, 5'000'000, 100}, {{0, 0, 0}}, "stray"},
      {"one at 1e18", 1.0, {}, {{1e18, 0, 0}}, "stray"},
      {"some at many scales",
       1.0,
       {},
       {{1e3, 0, 0}, {0, -1e3, 7}, {-1e9, 1e9, 0}, {0, 0, 1e38}},
       "stray"},
      {"no-data values",
       1.0,
       {3, 2, 1},
       {{kNoData, kNoData, kNoData}, {1.0, 2.0, kNoData}},
       "no-data value"},
      {"missing returns within the scan",
       1.0,
       {0.2, 0.1, 0.0},
       {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}},
       "missing return"},
  };
  for (const Placed& cloud : clouds) {
    INFO(cloud.name);
    std::vector<Vec3> points = sphere(2000, cloud.radius, cloud.center);
    write_cloud(in / "alone.txt", points, cloud.center);
    const std::string expected = mesh_of(in, "alone.txt");
    points.insert(points.begin() + 700, cloud.strays.begin(), cloud.strays.end());
    write_cloud(in / "strays.txt", points, cloud.center);
    CHECK((mesh_of(in, "strays.txt", {"--report", "report.json"}) == expected));
    const auto report = nlohmann::json::parse(test::file_text(in / "report.json"));
    std::uint64_t named = 0;
    for (const auto& [reason, count] : report.at("input").at("points_dropped").items())
      if (reason.find(cloud.reason) != std::string::npos) named += count.get<std::uint64_t>();
    CHECK(named == cloud.strays.size());
    CHECK(report.at("input").at("points_read") == 2000 + cloud.strays.size());
    const ProgramResult said =
        run_in(in, {"reconstruct", "strays.txt", "-o", "mesh.ply", "--progress", "plain"});
    CHECK_THAT(said.err, Contains(cloud.reason) && Contains("--keep-strays keeps them"));
    CHECK(names_in(in) == std::vector<std::string>{"alone.txt", "mesh.ply", "report.html",
                                                   "report.json", "strays.txt"});
    std::filesystem::remove(in / "report.json");
    std::filesystem::remove(in / "report.html");
  }
}

TEST_CASE("StraysThatAreKeptArePointsInEveryCut", "[costly]") {
  const ScratchDirectory in;
  for (const Vec3 stray : {Vec3{1e7, 0, 0}, Vec3{1e18, -1e18, 0}, Vec3{kNoData, 0, 0}}) {
    std::vector<Vec3> points = sphere(2000, 1.0, {});
    points.push_back(stray);
    write_cloud(in / "scan.txt", points, {});
    mesh_of(in, "scan.txt", {"--keep-strays", "--report", "report.json"});
    const auto report = nlohmann::json::parse(test::file_text(in / "report.json"));
    CHECK(report.at("input").at("points_dropped").empty());
    CHECK(report.at("mesh").at("vertices").get<int>() > 1900);
  }
}

TEST_CASE("TwoSurfacesFarApartAreOneJobInEveryCut", "[slow]") {
  const ScratchDirectory in;
  for (const double away : {1e6, 1e9}) {
    std::vector<Vec3> points = sphere(1500, 1.0, {});
    std::vector<Vec3> normals = points;
    for (const Vec3& p : sphere(1500, 1.0, {})) points.push_back(p + Vec3{away, 0, 0});
    std::ofstream file(in / "scan.txt");
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 n = normals[i % 1500];
      for (const double value : {points[i].x, points[i].y, points[i].z, n.x, n.y, n.z})
        file << format_exact(value) << ' ';
      file << '\n';
    }
    file.close();
    mesh_of(in, "scan.txt", {"--radii", "0.1"});
    mesh_of(in, "scan.txt");
  }
}

TEST_CASE("RadiiFarApartWorkInEveryCut", "[costly]") {
  const ScratchDirectory in;
  write_cloud(in / "scan.txt", sphere(2000, 1.0, {}), {});
  mesh_of(in, "scan.txt", {"--radii", "1.6e-6,0.1", "--no-fill"});
}

TEST_CASE("RadiiThatCannotBeComputedWithAreRefusedBeforeTheScanIsRead") {
  const ScratchDirectory in;
  test::write_text(in / "scan.txt", "this is no scan\n");
  for (const std::string radii : {"1e-300", "1e80", "1e-6,1"}) {
    const ProgramResult result =
        run_in(in, {"reconstruct", "scan.txt", "-o", "mesh.ply", "--radii", radii});
    CHECK(result.status == 2);
    CHECK_THAT(result.err, Contains("--ball-radii: ") && Contains("expected radii"));
    CHECK(names_in(in) == std::vector<std::string>{"scan.txt"});
  }
}

TEST_CASE("MissingReturnsOfPosedScansAreFoundAtTheirScanners") {
  const ScratchDirectory in;
  const std::vector<Vec3> points = sphere(2000, 1.0, {0.2, 0.1, 0.0});
  const auto job = [&](const std::string& scan) {
    test::write_text(in / "job.toml", "[input]\nfiles = [\"" + scan + "\"]\npose = [\"" + scan +
                                          " 10 20 30 0 0 0.6 0.8\"]\n[output]\nmesh = \"m.ply\"\n");
    const ProgramResult result = run_in(in, {"run", "job.toml"});
    INFO(result.err);
    REQUIRE(result.status == 0);
    return test::file_text(in / "m.ply");
  };
  write_cloud(in / "alone.txt", points, {0.2, 0.1, 0.0});
  std::vector<Vec3> with = points;
  with.insert(with.begin(), 5, Vec3{});
  write_cloud(in / "missing.txt", with, {0.2, 0.1, 0.0});
  CHECK((job("missing.txt") == job("alone.txt")));
}

TEST_CASE("NoDataValuesOfPosedScansAreFoundAsTheScanHasThem") {
  const ScratchDirectory in;
  const Vec3 center{0.2, 0.1, 0.0};
  const auto job = [&](const std::string& scan) {
    test::write_text(in / "job.toml", "[input]\nfiles = [\"" + scan + "\"]\npose = [\"" + scan +
                                          " 10 20 30 0.1 0.2 0.6 0.8\"]\n[output]\nmesh = "
                                          "\"m.ply\"\nreport = \"r.json\"\n");
    const ProgramResult result = run_in(in, {"run", "job.toml"});
    INFO(result.err);
    REQUIRE(result.status == 0);
    return test::file_text(in / "m.ply");
  };
  std::vector<Vec3> points = sphere(3000, 1.0, center);
  write_cloud(in / "alone.txt", points, center);
  // So many that they are no strays.
  for (int i = 0; i < 60; ++i) points.push_back({kNoData, i < 30 ? kNoData : 0.01 * i, kNoData});
  write_cloud(in / "nodata.txt", points, center);
  const std::string expected = job("alone.txt");
  CHECK((job("nodata.txt") == expected));
  const auto report = nlohmann::json::parse(test::file_text(in / "r.json"));
  const auto dropped = report.at("input").at("points_dropped");
  REQUIRE(dropped.size() == 1);
  CHECK_THAT(dropped.begin().key(), Contains("no-data value"));
  CHECK(dropped.begin().value() == 60);
}

TEST_CASE("ALonePointAtTheOriginIsAPoint") {
  const ScratchDirectory in;
  std::ofstream file(in / "plane.txt");
  for (int x = -10; x <= 10; ++x)
    for (int y = -10; y <= 10; ++y) file << x << ' ' << y << " 0 0 0 1\n";
  file.close();
  REQUIRE(run_in(in, {"reconstruct", "plane.txt", "-o", "m.ply", "--report", "r.json"}).status ==
          0);
  const auto report = nlohmann::json::parse(test::file_text(in / "r.json"));
  CHECK(report.at("mesh").at("vertices") == 21 * 21);
}

TEST_CASE("LonePointsAtTheOriginsOfSeveralScansArePoints") {
  const ScratchDirectory in;
  const auto left_out_with = [&](std::size_t in_a, std::size_t in_b) {
    std::vector<Vec3> points;
    for (int x = -10; x <= 10; ++x)
      for (int y = -10; y <= 10; ++y)
        if (x != 0 || y != 0) points.push_back({0.1 * x, 0.1 * y, 0.0});
    for (const auto& [name, at_origin] : {std::pair("a.txt", in_a), std::pair("b.txt", in_b)}) {
      std::vector<Vec3> scan = points;
      scan.insert(scan.end(), at_origin, Vec3{});
      write_cloud(in / name, scan, {0, 0, -1e6});
    }
    test::write_text(in / "job.toml",
                     "[input]\nfiles = [\"a.txt\", \"b.txt\"]\npose = [\"a.txt 0 0 0 0 0 0 1\", "
                     "\"b.txt 5 0 0 0 0 0 1\"]\n"
                     "[reconstruct]\nball_radii = [0.1]\n"
                     "[output]\nmesh = \"m.ply\"\nreport = \"r.json\"\n");
    const ProgramResult result = run_in(in, {"run", "job.toml"});
    INFO(result.err);
    REQUIRE(result.status == 0);
    const auto report = nlohmann::json::parse(test::file_text(in / "r.json"));
    std::uint64_t dropped = 0;
    for (const auto& [reason, count] : report.at("input").at("points_dropped").items())
      if (reason.find("missing return") != std::string::npos) dropped += count.get<std::uint64_t>();
    return dropped;
  };
  CHECK(left_out_with(1, 1) == 0);
  CHECK(left_out_with(0, 1) == 0);
  CHECK(left_out_with(3, 1) == 3);
  CHECK(left_out_with(2, 4) == 6);
}

TEST_CASE("PointsBeyondTheUsableRangeAreNamedWhetherStraysAreKeptOrNot") {
  const ScratchDirectory in;
  std::vector<Vec3> points = sphere(2000, 1.0, {});
  points.insert(points.begin() + 5, {{1e80, 0, 0}, {0, -1e200, 0}});
  write_cloud(in / "scan.txt", points, {});
  for (const char* option : {"--no-fill", "--keep-strays"}) {
    const ProgramResult said =
        run_in(in, {"reconstruct", "scan.txt", "-o", "mesh.ply", "--progress", "plain", option});
    CHECK(said.status == 0);
    CHECK_THAT(said.err, Contains("2 dropped: coordinate beyond 1e75") && Contains("no key keeps"));
  }
}

TEST_CASE("ScalesThatCannotBeComputedWithAreRefusedByName", "[costly]") {
  const ScratchDirectory in;
  struct Scale {
    double radius;
    std::string message;
  };
  for (const Scale& scale : {Scale{1e160, "coordinate beyond 1e75"},
                             Scale{1e-162, "the cloud is too small to be computed with"}}) {
    write_cloud(in / "scan.txt", sphere(500, scale.radius, {}), {});
    for (const std::uint64_t chunk : {100'000u, 50u}) {
      const ProgramResult result =
          run_in(in, cut_in(chunk, {"reconstruct", "scan.txt", "-o", "mesh.ply"}));
      CHECK(result.status == 3);
      CHECK_THAT(result.err, Contains("scan.txt") && Contains(scale.message));
      CHECK(names_in(in) == std::vector<std::string>{"scan.txt"});
    }
  }
  for (const double radius : {1e-60, 1e60}) {
    write_cloud(in / "scan.txt", sphere(2000, radius, {}), {});
    mesh_of(in, "scan.txt");
  }
}

}  // namespace orbweave
