// Jobs of scanners that moved: the side of the normals follows their path.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/meshes/mesh_reader.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using nlohmann::json;
using orbweave::test::file_text;
using orbweave::test::run_in;
using orbweave::test::ScratchDirectory;
using orbweave::test::write_text;

namespace {

std::string line_of(double a, double b, double c, double d) {
  char line[128];
  std::snprintf(line, sizeof line, "%.6f %.6f %.6f %.6f\n", a, b, c, d);
  return line;
}

/// The deck of a bridge, seen from below by a scanner that drives under it along x, a metre a
/// second.
std::string deck_from_below(bool reversed) {
  std::vector<std::string> lines;
  for (int i = 0; i < 3600; ++i) {
    const double x = 0.1 * (i % 60), y = 0.1 * (i / 60.0 - i % 60 / 60.0);
    lines.push_back(line_of(x, y, 6.0 + 0.02 * std::sin(x + 2.0 * y), 1000.0 + x));
  }
  std::string text = "x y z gps_time\n";
  for (std::size_t i = 0; i < lines.size(); ++i) text += lines[reversed ? lines.size() - 1 - i : i];
  return text;
}

/// Of a drive at this height, from `first` to `last`, ten places a second.
std::string drive(double height, int first, int last) {
  std::string text = "# time x y z\n";
  for (int i = 10 * first; i <= 10 * last; ++i)
    text += line_of(1000.0 + 0.1 * i, 0.1 * i, 3.0, height);
  return text;
}

/// The share of a mesh's faces that face down.
double share_down(const std::filesystem::path& path) {
  const orbweave::TriangleMesh mesh = orbweave::read_mesh(path);
  REQUIRE(mesh.triangles.size() > 1000);
  std::size_t down = 0;
  for (const orbweave::Triangle& t : mesh.triangles) {
    const orbweave::Vec3 a = mesh.vertices.positions[t[0]];
    const orbweave::Vec3 area =
        cross(mesh.vertices.positions[t[1]] - a, mesh.vertices.positions[t[2]] - a);
    down += area.z < 0.0 ? 1 : 0;
  }
  return static_cast<double>(down) / static_cast<double>(mesh.triangles.size());
}

}  // namespace

TEST_CASE("AJobTurnsTheSurfaceToThePathOfItsScanner") {
  const ScratchDirectory in;
  write_text(in / "deck.txt", deck_from_below(false));
  write_text(in / "below.txt", drive(2.0, -1, 7));
  write_text(in / "above.txt", drive(99.0, -1, 7));
  const auto mesh = [&](const std::string& out, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"reconstruct", "deck.txt", "-o",       out,
                                      "--progress",  "none",     "--report", "r.json"};
    words.insert(words.end(), more.begin(), more.end());
    const auto result = run_in(in, words);
    INFO(result.err);
    REQUIRE(result.status == 0);
    return share_down(in / out);
  };
  CHECK(mesh("b.ply", {"--trajectory", "below.txt"}) == 1.0);
  const json report = json::parse(file_text(in / "r.json"));
  CHECK(report["normals"]["orientation"] == "scanner");
  CHECK(mesh("a.ply", {"--trajectory", "above.txt"}) == 0.0);
  // Without it, a sheet is taken for one that is seen from above.
  CHECK(mesh("n.ply", {}) == 0.0);
}

TEST_CASE("AMeshByATrajectoryIsTheSameForAnyOrderChunksAndThreads", "[costly]") {
  const ScratchDirectory in;
  write_text(in / "a.txt", deck_from_below(false));
  write_text(in / "b.txt", deck_from_below(true));
  write_text(in / "path.txt", drive(2.0, -1, 7));
  const auto mesh = [&](const std::string& scan, const std::string& out,
                        const std::vector<std::string>& more) {
    std::vector<std::string> words = {"reconstruct",  scan,       "-o",         out,
                                      "--trajectory", "path.txt", "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    REQUIRE(run_in(in, words).status == 0);
    return file_text(in / out);
  };
  const std::string usual = mesh("a.txt", "1.ply", {});
  CHECK(mesh("b.txt", "2.ply", {"--chunk-points", "300", "--threads", "3"}) == usual);
  CHECK(mesh("b.txt", "3.ply", {"--threads", "1"}) == usual);
}

TEST_CASE("ATrajectoryThatDoesNotBelongToTheScansIsRefused") {
  const ScratchDirectory in;
  write_text(in / "deck.txt", deck_from_below(false));
  const auto refused = [&](const std::string& command, const std::string& path,
                           const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {command,        "deck.txt", "-o",         "m.ply",
                                      "--trajectory", path,       "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    const auto result = run_in(in, words);
    CHECK_FALSE(exists(in / "m.ply"));
    return std::to_string(result.status) + " " + result.err;
  };
  write_text(in / "half.txt", drive(2.0, -1, 3));
  write_text(in / "far.txt", "1000 5000000 400000 2\n1007 5000007 400000 2\n");
  for (const char* command : {"reconstruct", "plan"}) {
    INFO(command);
    CHECK_THAT(refused(command, "half.txt"),
               Contains("3 orbweave: error: half.txt: the trajectory does not cover the scans") &&
                   Contains("times from 999 to 1003, and points from 1000 to 1005.9") &&
                   Contains("of 3,600 of them") && Contains("or leave --trajectory out"));
    CHECK_THAT(refused(command, "far.txt"),
               Contains("3 orbweave: error: far.txt: the trajectory lies far from the scans"));
    CHECK_THAT(refused(command, "none.txt"), Contains("3 orbweave: error: none.txt"));
  }
  write_text(in / "path.txt", drive(2.0, -1, 7));
  CHECK_THAT(refused("reconstruct", "path.txt", {"--scanner", "1,2,3"}),
             Contains("2 orbweave: error: --trajectory and --scanner both say where"));
  write_text(in / "untimed.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  const auto untimed =
      run_in(in, {"reconstruct", "untimed.xyz", "-o", "m.ply", "--trajectory", "path.txt"});
  CHECK(untimed.status == 3);
  CHECK_THAT(untimed.err, Contains("untimed.xyz: the points have no time"));
}

TEST_CASE("AFewPointsThatATrajectoryDoesNotCoverAreLeftOutAndCounted") {
  const ScratchDirectory in;
  write_text(in / "deck.txt", deck_from_below(false) + line_of(3, 3, 6, 0) + line_of(2, 3, 6, 5e9));
  write_text(in / "path.txt", drive(2.0, -1, 7));
  const auto result = run_in(in, {"reconstruct", "deck.txt", "-o", "m.ply", "--trajectory",
                                  "path.txt", "--report", "r.json", "--progress", "none"});
  REQUIRE(result.status == 0);
  const json input = json::parse(file_text(in / "r.json"))["input"];
  CHECK(input["points_dropped"]["at a time that the trajectory does not cover"] == 2);
}

TEST_CASE("AnotherTrajectoryIsNotTakenForTheOneOfTheRunBefore") {
  const ScratchDirectory in;
  write_text(in / "deck.txt", deck_from_below(false));
  const auto run = [&](double height) {
    write_text(in / "path.txt", drive(height, -1, 7));
    const auto result = run_in(in, {"reconstruct", "deck.txt", "-o", "m.ply", "--trajectory",
                                    "path.txt", "--keep-work-dir", "--progress", "none"});
    REQUIRE(result.status == 0);
    return share_down(in / "m.ply");
  };
  CHECK(run(2.0) == 1.0);
  CHECK(run(99.0) == 0.0);
}

TEST_CASE("ATrajectoryThatDecidesNothingIsSaidSo") {
  const ScratchDirectory in;
  write_text(in / "a.xyz",
             "x y z nx ny nz time\n0 0 0 0 0 1 1\n1 0 0 0 0 1 1\n0 1 0 0 0 1 2\n1 1 0 0 0 1 2\n");
  write_text(in / "path.txt", "0 0 0 9\n3 1 1 9\n");
  const auto result = run_in(in, {"reconstruct", "a.xyz", "-o", "m.ply", "--ball-radii", "1",
                                  "--trajectory", "path.txt", "--progress", "none"});
  CHECK(result.status == 0);
  CHECK_THAT(result.err, Contains("--trajectory decides nothing"));
  write_text(in / "deck.txt", deck_from_below(false));
  write_text(in / "drive.txt", drive(2.0, -1, 7));
  const auto up = run_in(in, {"reconstruct", "deck.txt", "-o", "d.ply", "--orientation", "up",
                              "--trajectory", "drive.txt", "--progress", "none"});
  CHECK(up.status == 0);
  CHECK_THAT(up.err, Contains("--trajectory decides nothing: --orientation up decides the side of "
                              "the normals; --orientation auto goes by the scanner"));
}
