// Jobs as a user runs them: the same job from a file and from the command line, what is planned,
// what an interruption leaves, and that the same command then finishes.
#include <signal.h>

#include <catch2/catch.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using nlohmann::json;
using orbweave::test::file_text;
using orbweave::test::names_in;
using orbweave::test::ProgramResult;
using orbweave::test::run_in;
using orbweave::test::run_program;
using orbweave::test::RunningProgram;
using orbweave::test::ScratchDirectory;
using orbweave::test::write_text;

namespace {

void generate(const ScratchDirectory& in, const std::string& points) {
  REQUIRE(run_in(in, {"generate", "torus", "--points", points, "-o", "scan.ply"}).status == 0);
}

const char* const kJob =
    "[input]\nfiles = [\"scan.ply\"]\n[partition]\nchunk_points = 1000\n"
    "[output]\nmesh = \"mesh.ply\"\n[run]\nthreads = 1\n";

/// Signals the job when its points are sorted and no hole is looked at, however quick it is: it is
/// held meanwhile. Its mesh and its report are removed where it ends before.
ProgramResult interrupted_run(const ScratchDirectory& in, const std::vector<std::string>& command,
                              int signal) {
  constexpr int kMostTries = 20;
  const std::filesystem::path work = in / "mesh.work";
  for (int tries = 0; tries < kMostTries; ++tries) {
    RunningProgram program(command, {.directory = in.path()});
    const auto sorted = [&] { return exists(work / "points" / "partition.json.xxh3"); };
    const bool in_time = program.hold_when(sorted) && !exists(work / "holes");
    if (in_time) program.send(signal);
    program.release();
    ProgramResult result = program.wait();
    if (in_time) return result;
    for (const char* name : {"mesh.ply", "report.json", "report.html"})
      std::filesystem::remove(in / name);
  }
  FAIL("the job ends before it can be interrupted");
  return {};
}

}  // namespace

TEST_CASE("ARunThatFindsItsOutputsWholeSaysThatItRemovesTheWorkDirectoryThatWasKept") {
  const ScratchDirectory in;
  generate(in, "2000");
  write_text(in / "job.toml", kJob);
  REQUIRE(run_in(in, {"run", "job.toml", "--keep-work-dir"}).status == 0);
  const ProgramResult again = run_in(in, {"run", "job.toml"});
  CHECK(again.status == 0);
  CHECK_THAT(again.out, Contains("mesh.ply") &&
                            Contains("whole, as an earlier run of this job wrote it") &&
                            Contains("mesh.work, the work directory that it left, is removed"));
  CHECK_THAT(again.out, !Contains("killed"));
  CHECK_FALSE(exists(in / "mesh.work"));
}

TEST_CASE("JobFileAndCommandLineMakeTheSameMesh") {
  const ScratchDirectory in;
  generate(in, "5000");
  write_text(in / "job.toml", kJob);
  const auto run = run_in(in, {"run", "job.toml", "--progress", "none"});
  CHECK(run.status == 0);
  CHECK(run.err.empty());
  CHECK_THAT(run.out, Contains("mesh.ply") && Contains("10,000 triangles, closed"));
  const std::string mesh = file_text(in / "mesh.ply");
  CHECK(run_in(in, {"reconstruct", "scan.ply", "-o", "other.ply", "--threads", "2"}).status == 0);
  CHECK(mesh == file_text(in / "other.ply"));
  CHECK(names_in(in) == std::vector<std::string>{"job.toml", "mesh.ply", "other.ply", "scan.ply"});
}

TEST_CASE("CommandLineWinsOverTheJobFile") {
  const ScratchDirectory in;
  generate(in, "2000");
  write_text(in / "job.toml", kJob);
  const auto run =
      run_in(in, {"run", "job.toml", "--set", "run.threads=3", "--set",
                  "reconstruct.ball_radii=0.12,0.2", "--threads", "2", "--memory", "512MiB",
                  "--work-dir", "here.work", "--keep-work-dir", "--report", "report.json"});
  CHECK(run.status == 0);
  const json options = json::parse(file_text(in / "report.json"))["options"];
  CHECK(options["run"]["threads"] == 2);
  CHECK(options["partition"]["memory"] == 512 << 20);
  CHECK(options["partition"]["chunk_points"] == 1000);
  CHECK(options["reconstruct"]["ball_radii"] == json({0.12, 0.2}));
  CHECK(std::filesystem::exists(in / "here.work"));
}

namespace {

/// A command with every documented option of `reconstruct`, word by word.
std::vector<std::string> every_option() {
  std::istringstream words(
      "reconstruct scan.ply -o mesh.ply --radii 0.12,0.2 --method ball_pivoting --no-fill "
      "--kernel triharmonic --neighborhood 2.5 --max-diameter 1.5 --max-perimeter 4 "
      "--max-edges 99 --close-outer-border --allow-intersections --uniform-patches "
      "--min-triangles 3 --patch-color #4477cc --levels 2 --chunk-points 500 --memory 1GiB "
      "--threads 2 --work-dir w --fresh --report report.json --picture mesh.png --precision "
      "float --format text --no-attributes --progress plain");
  return {std::istream_iterator<std::string>(words), {}};
}

}  // namespace

TEST_CASE("EveryDocumentedOptionOfReconstructReachesTheJob", "[costly]") {
  const ScratchDirectory in;
  generate(in, "2000");
  const auto run = run_in(in, every_option());
  CHECK(run.status == 0);
  const json report = json::parse(file_text(in / "report.json"));
  CHECK(report["options"]["reconstruct"]["levels"] == 2);
  CHECK(report["options"]["fill"] == json({{"enabled", false},
                                           {"kernel", "triharmonic"},
                                           {"neighborhood", 2.5},
                                           {"max_diameter", 1.5},
                                           {"max_perimeter", 4.0},
                                           {"max_edges", 99},
                                           {"keep_outer_border", false},
                                           {"allow_intersections", true},
                                           {"graded", false},
                                           {"min_triangles", 3}}));
  CHECK(report["options"]["output"]["patch_color"] == "#4477cc");
  CHECK(report["options"]["partition"]["chunk_points"] == 500);
  CHECK(report["partition"]["chunks"] > 1);
  CHECK(report["command"][1] == "reconstruct");
  CHECK_THAT(file_text(in / "mesh.ply"),
             Contains("format ascii") && Contains("float x") && !Contains("property float nx"));
  CHECK(file_text(in / "mesh.png").substr(1, 3) == "PNG");
  CHECK(!std::filesystem::exists(in / "w"));
}

TEST_CASE("DashStreamsTheMeshToStandardOutput") {
  const ScratchDirectory in;
  generate(in, "2000");
  REQUIRE(run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.ply"}).status == 0);
  const auto streamed = run_in(in, {"reconstruct", "scan.ply", "-o", "-"});
  CHECK(streamed.status == 0);
  CHECK(streamed.out == file_text(in / "mesh.ply"));
  CHECK(names_in(in) == std::vector<std::string>{"mesh.ply", "scan.ply"});
}

TEST_CASE("PlanForetellsTheRunAndWritesNothing", "[costly]") {
  const ScratchDirectory in;
  generate(in, "5000");
  write_text(in / "job.toml", kJob);
  const auto before = names_in(in);
  const auto plan = run_in(in, {"plan", "job.toml", "--json", "--progress", "none"});
  CHECK(plan.status == 0);
  CHECK(names_in(in) == before);
  const json planned = json::parse(plan.out);
  REQUIRE(run_in(in, {"run", "job.toml", "--report", "report.json"}).status == 0);
  const json report = json::parse(file_text(in / "report.json"));
  CHECK(planned["input"]["points"] == 5000);
  CHECK(planned["partition"]["chunks"] == report["partition"]["chunks"]);
  CHECK(planned["radii"]["values"] == report["radii"]["values"]);
  CHECK_THAT(run_in(in, {"plan", "job.toml"}).out,
             Contains("points       5,000\n") && Contains("peak memory  about ") &&
                 Contains(" times the point spacing ") && Contains("time         about "));
}

TEST_CASE("PlanSaysWhatTheOptionsDoToHoles") {
  const ScratchDirectory in;
  generate(in, "2000");
  write_text(in / "job.toml", kJob);
  CHECK_THAT(run_in(in, {"plan", "job.toml"}).out,
             Contains("holes        filled (biharmonic, neighborhood 2 times the radius)\n") &&
                 Contains("left open    outer borders of open sheets, wide gaps of open scenes\n"));
  CHECK_THAT(run_in(in, {"plan", "job.toml", "--set", "fill.keep_outer_border=false", "--set",
                         "fill.max_edges=60", "--set", "fill.max_diameter=0.5", "--set",
                         "fill.min_triangles=9"})
                 .out,
             Contains("left open    holes of more than 60 edges, holes wider than 0.5\n") &&
                 Contains("removed      separate pieces of fewer than 9 triangles\n"));
  const std::vector<std::string> no_fill = {"plan", "job.toml", "--set", "fill.enabled=false"};
  CHECK_THAT(run_in(in, no_fill).out,
             Contains("holes        all stay open (fill.enabled = false)\n"));
  const json planned = json::parse(run_in(in, {"plan", "job.toml", "--json"}).out);
  CHECK(planned["fill"]["left_open"] ==
        json({"outer borders of open sheets", "wide gaps of open scenes"}));
}

TEST_CASE("SummaryAndReportCountThePointsThatTightCoconeLeavesOut") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "1000", "--noise", "1.5", "-o", "scan.ply"})
              .status == 0);
  const auto done = run_in(in, {"reconstruct", "scan.ply", "--method", "tight_cocone", "-o",
                                "mesh.ply", "--report", "report.json"});
  if (done.status == 2) {
    CHECK_THAT(done.err, Contains("without the methods of the Voronoi family"));
    return;
  }
  REQUIRE(done.status == 0);
  const int unused = json::parse(file_text(in / "report.json"))["points_unused"];
  REQUIRE(unused > 1);
  CHECK_THAT(done.out + done.err, Contains("unused   " + std::to_string(unused) +
                                           " points of the scan that no triangle uses\n"));
}

TEST_CASE("SummaryCountsThePointsThatTheMeshLacks") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "1000", "--noise", "1.5", "-o", "scan.ply"})
              .status == 0);
  const auto done = run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.ply", "--outlier-sigma", "2",
                                "--report", "report.json"});
  REQUIRE(done.status == 0);
  const json report = json::parse(file_text(in / "report.json"));
  const int unused = report["points_unused"];
  const int outliers = report["input"]["points_dropped"]["outlier"];
  REQUIRE((unused > 1 && outliers > 1));
  CHECK_THAT(done.out,
             Contains("\ndropped  ") &&
                 Contains(std::to_string(outliers) + " points: " + std::to_string(outliers) +
                          " outlier\n") &&
                 Contains(std::to_string(unused) + " points of the scan that no triangle uses\n"));
}

TEST_CASE("StatusOfWhatIsNoWorkDirectoryIsWrongUsage") {
  const ScratchDirectory in;
  const auto status = run_in(in, {"status", "nowhere"});
  CHECK(status.status == 2);
  CHECK_THAT(status.err, Contains("nowhere") && Contains("no work directory"));
}

TEST_CASE("StatusShowsTheStagesOfAKeptWorkDirectory") {
  const ScratchDirectory in;
  generate(in, "5000");
  write_text(in / "job.toml", kJob);
  REQUIRE(run_in(in, {"run", "job.toml", "--keep-work-dir"}).status == 0);
  const auto status = run_in(in, {"status", "mesh.work"});
  CHECK(status.status == 0);
  CHECK_THAT(status.out, Contains("last touched") && Contains("points") && Contains("done"));
  const json document = json::parse(run_in(in, {"status", "mesh.work", "--json"}).out);
  CHECK(document["running"] == false);
  for (const json& stage : document["stages"]) {
    CHECK(stage["done"] == true);
    CHECK(stage["chunks_done"] == stage["chunks_total"]);
  }
}

TEST_CASE("StatusOfAJobWithoutHolesLeavesNothingOpen") {
  const ScratchDirectory in;
  generate(in, "2000");
  REQUIRE(run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.ply", "--keep-work-dir", "--tileset",
                      "levels"})
              .status == 0);
  const auto status = run_in(in, {"status", "mesh.work"});
  CHECK_THAT(status.out, Contains("job             ended; all outputs are written\n") &&
                             Catch::Matches("(.|\n)*holes +done +0 +0 +0\n(.|\n)*") &&
                             Catch::Matches("(.|\n)*tileset +done +[0-9]+ +0 +0\n(.|\n)*") &&
                             !Contains("?") && !Contains("not known") && !Contains("stopped"));
}

TEST_CASE("InterruptedJobLeavesNoMeshAndTheSameCommandFinishesWithTheSameBytes", "[costly]") {
  const ScratchDirectory in;
  const ScratchDirectory undisturbed;
  const int signal = GENERATE(SIGINT, SIGTERM);
  generate(in, "30000");
  std::filesystem::copy_file(in / "scan.ply", undisturbed / "scan.ply");
  const std::vector<std::string> command = {
      "reconstruct", "scan.ply",       "-o",   "mesh.ply", "--threads",
      "1",           "--chunk-points", "1000", "--report", "report.json"};
  const ProgramResult interrupted = interrupted_run(in, command, signal);
  CHECK(interrupted.status == 130);
  CHECK_THAT(interrupted.err, Contains("orbweave: error: interrupted. What is done is kept in "
                                       "mesh.work; the same command resumes"));
  CHECK(names_in(in) == std::vector<std::string>{"mesh.work", "scan.ply"});
  const json left = json::parse(run_in(in, {"status", "mesh.work", "--json"}).out);
  CHECK(left["running"] == false);
  CHECK(left["stages"][0]["done"] == true);

  const ProgramResult resumed = run_in(in, command);
  CHECK(resumed.status == 0);
  CHECK_THAT(resumed.err, Contains("resuming"));
  REQUIRE(run_in(undisturbed, command).status == 0);
  CHECK(file_text(in / "mesh.ply") == file_text(undisturbed / "mesh.ply"));
  CHECK(!std::filesystem::exists(in / "mesh.work"));
}

TEST_CASE("EveryStageSaysHowMuchItHasDone") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "plane", "--points", "3000", "-o", "scan.ply"}).status == 0);
  const auto result = run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.ply", "--normals",
                                  "estimate", "--progress", "plain"});
  CHECK(result.status == 0);
  for (const char* stage : {"measure: done", "orient: done", "trace: done"})
    CHECK_THAT(result.err, Contains(stage));
  for (const char* nothing : {", 0 places", ", 0 patches", ", 0 edges"})
    CHECK_THAT(result.err, !Contains(nothing));
}

TEST_CASE("TilesAreNamedInTheSummaryAndAnOlderMeshIsNotTakenForTheirs") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "2000", "-o", "scan.ply"}).status == 0);
  const std::vector<std::string> job = {"reconstruct", "scan.ply", "-o", "mesh.ply", "--tiles"};
  const auto alone = run_in(in, job);
  CHECK_THAT(alone.out, Contains("tiles") && Contains("mesh.tiles") && !Contains("mesh.ply"));
  write_text(in / "mesh.ply", "an older mesh");
  const auto beside = run_in(in, job);
  CHECK_THAT(beside.out, Contains("mesh.ply is not of this run"));
  CHECK(file_text(in / "mesh.ply") == "an older mesh");
}

TEST_CASE("ADamagedResultIsToldInOneLineAndNoOtherWarningComesTwice") {
  const ScratchDirectory in;
  generate(in, "3000");
  std::vector<std::string> job = {"reconstruct",    "scan.ply", "-o",         "mesh.ply",
                                  "--chunk-points", "500",      "--progress", "none"};
  job.insert(job.end(), {"--units-per-meter", "1000000000", "--keep-work-dir"});
  const auto whole = run_in(in, job);
  REQUIRE(whole.status == 0);
  REQUIRE_THAT(whole.err, Contains("check the units"));
  const std::string mesh = file_text(in / "mesh.ply");
  const auto result = in / "mesh.work" / "mesh" / "000001.h5";
  std::string bytes = file_text(result);
  for (std::size_t i = bytes.size() / 3; i < bytes.size(); i += 97)
    bytes[i] = static_cast<char>(bytes[i] ^ 1);
  write_text(result, bytes);
  job.insert(job.end(), {"--report", "report.json"});
  const auto again = run_in(in, job);
  CHECK(again.status == 0);
  const std::size_t told = again.err.find("a stored result is damaged");
  REQUIRE(told != std::string::npos);
  // Without that line, what the first run said.
  const std::size_t begin = again.err.rfind('\n', told) + 1;
  const std::size_t end = again.err.find('\n', told) + 1;
  CHECK(again.err.substr(0, begin) + again.err.substr(end) == whole.err);
  CHECK(file_text(in / "mesh.ply") == mesh);
}
