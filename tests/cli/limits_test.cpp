// Limits of memory, files and patience: what the user is told, the exit status, and what lies on
// disk afterwards.
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using orbweave::test::file_text;
using orbweave::test::names_in;
using orbweave::test::ProgramResult;
using orbweave::test::run_in;
using orbweave::test::run_limited;
using orbweave::test::RunningProgram;
using orbweave::test::ScratchDirectory;
using orbweave::test::write_text;

namespace {

using Names = std::vector<std::string>;

/// A cloud of a torus without normals; returns how far its points are apart.
double write_bare_torus(const ScratchDirectory& in, const std::string& name, int points) {
  REQUIRE(run_in(in, {"generate", "torus", "--points", std::to_string(points), "-o", "full.ply"})
              .status == 0);
  REQUIRE(run_in(in, {"convert", "full.ply", "full.csv"}).status == 0);
  const auto facts = run_in(in, {"inspect", "full.ply", "--json"});
  REQUIRE(facts.status == 0);
  std::string bare;
  const std::string text = file_text(in / "full.csv");
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    std::size_t cut = at;
    for (int field = 0; field < 3; ++field) cut = text.find_first_of(",\n", cut) + 1;
    bare += text.substr(at, cut - 1 - at) + "\n";
    at = end + 1;
  }
  write_text(in / name, bare);
  for (const char* made : {"full.ply", "full.csv"}) std::filesystem::remove(in / made);
  return nlohmann::json::parse(facts.out).at("spacing");
}

Names reconstruction(const std::string& scan, const Names& more = {}) {
  Names arguments = {"reconstruct", scan, "-o", "mesh.ply", "--threads", "2"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

ProgramResult reconstruct(const ScratchDirectory& in, const std::string& scan,
                          const Names& more = {}) {
  return run_in(in, reconstruction(scan, more));
}

/// Text whose lines end as those of old Macs.
std::string with_cr(std::string text) {
  std::replace(text.begin(), text.end(), '\n', '\r');
  return text;
}

}  // namespace

TEST_CASE("TheLeastBudgetOfAllStagesIsCheckedBeforeTheFirst") {
  const ScratchDirectory in;
  write_bare_torus(in, "scan.csv", 2000);
  // Enough for points as they are read, not for points with their normals.
  const auto result = reconstruct(in, "scan.csv", {"--memory", "191MiB", "--normals", "estimate"});
  CHECK(result.status == 4);
  CHECK_THAT(result.err, Contains("--memory: the memory budget is too small; found 191 MiB") &&
                             Contains("expected at least 192 MiB for 2 threads"));
  CHECK_THAT(result.err, !Contains("raw bin"));
  // Nothing was done that could be resumed.
  CHECK_THAT(result.err, !Contains("What is done is kept"));
  CHECK(names_in(in) == Names{"scan.csv"});
  CHECK(reconstruct(in, "scan.csv", {"--memory", "192MiB", "--normals", "estimate"}).status == 0);
  CHECK(names_in(in) == Names{"mesh.ply", "scan.csv"});
}

TEST_CASE("NormalsReachAcrossMergedPoints", "[costly]") {
  const ScratchDirectory in;
  const double spacing = write_bare_torus(in, "scan.csv", 20000);
  for (const double spacings : {1.0, 3.0, 3.6}) {
    CAPTURE(spacings);
    const auto result = reconstruct(in, "scan.csv",
                                    {"--normals", "estimate", "--report", "report.json",
                                     "--merge-tolerance", std::to_string(spacings * spacing)});
    CHECK(result.status == 0);
    const auto report = nlohmann::json::parse(file_text(in / "report.json"));
    CHECK(report.at("mesh").at("watertight") == true);
    const auto& dropped = report.at("input").at("points_dropped");
    CHECK(dropped.contains("merged with another point"));
    CHECK(!dropped.contains("too few neighbours for a normal"));
  }
}

TEST_CASE("MergedPointsGetTheSameNormalsInAnyCut", "[costly]") {
  const ScratchDirectory in;
  const double spacing = write_bare_torus(in, "scan.csv", 20000);
  std::string whole;
  for (const char* chunk_points : {"100000", "5000", "1500"}) {
    REQUIRE(reconstruct(in, "scan.csv",
                        {"--normals", "estimate", "--chunk-points", chunk_points,
                         "--merge-tolerance", std::to_string(3.0 * spacing)})
                .status == 0);
    if (whole.empty()) whole = file_text(in / "mesh.ply");
    CHECK(file_text(in / "mesh.ply") == whole);
  }
}

TEST_CASE("WhereNoPointIsLeftTheReasonsAreCounted") {
  const ScratchDirectory in;
  write_text(in / "row.xyz", "0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n");
  const auto row = reconstruct(in, "row.xyz", {"--normals", "estimate"});
  CHECK(row.status == 3);
  CHECK_THAT(row.err,
             Contains("row.xyz: no point is left to make a mesh of; found 5 points read; 5 "
                      "dropped: too few neighbours for a normal") &&
                 Contains("not all on a line") && Contains("--normals file"));
  CHECK(names_in(in) == Names{"row.xyz"});
  write_text(in / "zero.xyz", "0 0 0 0 0 0\n1 0 0 0 0 0\nnan 0 0 0 0 1\n");
  const auto zero = reconstruct(in, "zero.xyz", {"--columns", "x,y,z,nx,ny,nz"});
  CHECK(zero.status == 3);
  CHECK_THAT(zero.err, Contains("the cloud holds no usable point; found 3 points read; 1 dropped: "
                                "coordinate not finite, 2 dropped: zero normal"));
  CHECK(names_in(in) == Names{"row.xyz", "zero.xyz"});
}

TEST_CASE("LinesMayEndInCarriageReturns") {
  const ScratchDirectory in;
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n";
  const std::string pcd =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\n"
      "HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n";
  const std::string ptx = "3\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  const std::string rows = "0.5 0.25 0\n1 0 0\n0 1 0.125\n";
  const std::string rows4 = "0.5 0.25 0 0.5\n1 0 0 0.5\n0 1 0.125 0.5\n";
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"a.xyz", rows},
           {"a.csv", "x,y,z\n0.5,0.25,0\n1,0,0\n0,1,0.125\n"},
           {"a.pts", "3\n" + rows4},
           {"a.ptx", ptx + rows4},
           {"a.pcd", pcd + rows},
           {"a.ply", header + rows}}) {
    CAPTURE(name);
    write_text(in / name, text);
    const auto usual = run_in(in, {"inspect", name, "--json"});
    REQUIRE(usual.status == 0);
    CHECK(nlohmann::json::parse(usual.out).at("points") == 3);
    write_text(in / name, with_cr(text));
    const auto result = run_in(in, {"inspect", name, "--json"});
    CHECK(result.status == 0);
    CHECK(result.out == usual.out);
  }
}

TEST_CASE("ALimitOfFileSizesIsAnErrorAndNoDeath") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "3000", "-o", "scan.ply"}).status == 0);
  // In blocks of 512 bytes: too little for a stored chunk, for the mesh.
  for (const char* blocks : {"16", "128"}) {
    CAPTURE(blocks);
    const auto result =
        run_limited(in, std::string("ulimit -f ") + blocks, reconstruction("scan.ply"));
    CHECK(result.status == 4);
    CHECK_THAT(result.err, Contains("File too large") && Contains("ulimit -f") &&
                               Contains("mesh.work; the same command resumes"));
    CHECK(names_in(in) == Names{"mesh.work", "scan.ply"});
  }
  CHECK(reconstruct(in, "scan.ply").status == 0);
  CHECK(names_in(in) == Names{"mesh.ply", "scan.ply"});
}

TEST_CASE("ASignalEndsAReadThatNeverEnds") {
  const ScratchDirectory in;
  REQUIRE(mkfifo((in / "pipe.xyz").c_str(), 0600) == 0);
  // Nobody writes: opened for both, so that the program waits for the first byte.
  const int held = open((in / "pipe.xyz").c_str(), O_RDWR | O_CLOEXEC);
  REQUIRE(held >= 0);
  RunningProgram program({"convert", "pipe.xyz", "cloud.ply"}, {.directory = in.path()});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  program.send(SIGTERM);
  const auto result = program.wait();
  close(held);
  CHECK(result.status == 130);
  CHECK_THAT(result.err, Contains("interrupted"));
  CHECK(names_in(in) == Names{"pipe.xyz"});
}
