// Everything that goes wrong with a scan or a job: the message names file, place and remedy, the
// exit status is the contract's, and no output file is left, whole or in parts.
#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using orbweave::test::file_text;
using orbweave::test::names_in;
using orbweave::test::program_path;
using orbweave::test::ProgramResult;
using orbweave::test::run_program;
using orbweave::test::ScratchDirectory;
using orbweave::test::write_text;

namespace {

/// "reconstruct SCAN -o mesh.ply MORE..." in the directory.
ProgramResult reconstruct(const ScratchDirectory& in, const std::string& scan,
                          const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = {"reconstruct", scan, "-o", "mesh.ply", "--threads", "2"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_program(arguments, {.directory = in.path()});
}

void generate(const ScratchDirectory& in, const std::string& shape, const std::string& points,
              const std::string& name) {
  const auto result = run_program({"generate", shape, "--points", points, "-o", name, "--float"},
                                  {.directory = in.path()});
  REQUIRE(result.status == 0);
}

/// Scans whose noise is large enough for a cleaning, without normals.
void generate_noisy(const ScratchDirectory& in, const std::string& name,
                    const std::string& noise = "0.4") {
  const auto result = run_program(
      {"generate", "bumpy-torus", "--points", "8000", "--noise", noise, "--scans", "4", "-o", name},
      {.directory = in.path()});
  REQUIRE(result.status == 0);
}

void check_no_mesh(const ScratchDirectory& in) {
  for (const auto& entry : std::filesystem::directory_iterator(in.path())) {
    const std::string name = entry.path().filename().string();
    CAPTURE(name);
    CHECK(name.find("mesh.ply") == std::string::npos);
    CHECK(name.find(".part") == std::string::npos);
  }
}

/// A text cloud whose points all have the normal (0, 0, 1).
std::string cloud_text(const std::vector<std::string>& positions) {
  std::string text;
  for (const std::string& position : positions) text += position + " 0 0 1\n";
  return text;
}

ProgramResult reconstruct_text(const ScratchDirectory& in, const std::string& text,
                               const std::vector<std::string>& more = {}) {
  write_text(in / "scan.xyz", text);
  return reconstruct(in, "scan.xyz", more);
}

}  // namespace

TEST_CASE("MissingScanIsBadInput") {
  const ScratchDirectory in;
  const auto result = reconstruct(in, "missing.ply");
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("orbweave: error: missing.ply: "));
  CHECK_THAT(result.err, Contains("no such file", Catch::CaseSensitive::No));
  check_no_mesh(in);
}

TEST_CASE("DirectoryAsScanIsBadInput") {
  const ScratchDirectory in;
  std::filesystem::create_directory(in / "scan.ply");
  const auto result = reconstruct(in, "scan.ply");
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("scan.ply: ") && Contains("directory"));
  check_no_mesh(in);
}

TEST_CASE("TruncatedBinaryPlyIsBadInput") {
  const ScratchDirectory in;
  generate(in, "sphere", "1000", "whole.ply");
  const std::string whole = file_text(in / "whole.ply");
  write_text(in / "scan.ply", whole.substr(0, whole.size() / 2));
  const auto result = reconstruct(in, "scan.ply");
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("scan.ply: ") && Contains("shorter than its header says") &&
                             Contains("expected 1000 rows"));
  check_no_mesh(in);
}

TEST_CASE("PlyHeaderThatLiesAboutItsCountIsBadInput") {
  const ScratchDirectory in;
  generate(in, "sphere", "1000", "whole.ply");
  std::string text = file_text(in / "whole.ply");
  const std::string claimed = GENERATE("9000", "900000000000000");
  CAPTURE(claimed);
  text.replace(text.find("element vertex 1000"), 19, "element vertex " + claimed);
  write_text(in / "scan.ply", text);
  const auto result = reconstruct(in, "scan.ply");
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("scan.ply: ") && Contains(claimed));
  check_no_mesh(in);
}

TEST_CASE("LetterInLineSevenIsBadInputThatNamesTheLine") {
  const ScratchDirectory in;
  std::vector<std::string> positions(12, "0.5 0.25 0.125");
  positions[6] = "0.5 0.2x5 0.125";
  const auto result = reconstruct_text(in, cloud_text(positions));
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("scan.xyz: line 7") && Contains("0.2x5"));
  check_no_mesh(in);
}

TEST_CASE("NothingButNanIsBadInput") {
  const ScratchDirectory in;
  const auto result = reconstruct_text(in, cloud_text(std::vector<std::string>(20, "nan nan nan")));
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("20 dropped: coordinate not finite"));
  check_no_mesh(in);
}

TEST_CASE("CloudThatCannotFormATriangleIsBadInputThatSaysWhy", "[costly]") {
  struct Case {
    std::vector<std::string> positions;
    const char* why;
  };
  std::vector<std::string> line;
  for (int i = 0; i < 50; ++i)
    line.push_back(std::to_string(i) + " " + std::to_string(2 * i) + " 1");
  const Case given = GENERATE_COPY(
      Case{{"1 2 3"}, "1 distinct point,"}, Case{{"1 2 3", "2 2 3"}, "2 distinct points,"},
      Case{std::vector<std::string>(30, "1 2 3"), "1 distinct point,"}, Case{line, "on one line"});
  CAPTURE(given.positions);
  const std::vector<std::string> radii =
      GENERATE(std::vector<std::string>{}, std::vector<std::string>{"--radii", "3"});
  const ScratchDirectory in;
  const auto result = reconstruct_text(in, cloud_text(given.positions), radii);
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("no triangle") && Contains(given.why));
  check_no_mesh(in);
}

TEST_CASE("ScanLinesThatAutomaticRadiiDoNotBridgeLeadToAdviceThatDoes") {
  const auto lines = [](int apart) {  // as many points on a line before the next line
    std::vector<std::string> points;
    for (int i = 0; i < 400; ++i)
      points.push_back(std::to_string(i % 80) + " " + std::to_string(i / 80 * apart) + " 0");
    return cloud_text(points);
  };
  const ScratchDirectory in;
  const auto automatic = reconstruct_text(in, lines(80));
  CHECK(automatic.status == 3);
  CHECK_THAT(automatic.err, Contains("half the distance between the lines") &&
                                Contains("--ball-radii") && !Contains("--ball-radii auto"));
  const auto given = reconstruct_text(in, lines(80), {"--ball-radii", "2"});
  CHECK(given.status == 3);
  CHECK_THAT(given.err, Contains("try --ball-radii auto"));
  CHECK(reconstruct_text(in, lines(80), {"--ball-radii", "48"}).status == 0);
  CHECK(reconstruct_text(in, lines(10)).status == 0);
}

TEST_CASE("CoplanarPointsMakeAFlatSheet") {
  const ScratchDirectory in;
  generate(in, "plane", "400", "scan.ply");
  CHECK(reconstruct(in, "scan.ply").status == 0);
  CHECK(std::filesystem::exists(in / "mesh.ply"));
}

TEST_CASE("CloudWithoutNormalsIsBadInputWhereTheyAreToComeFromTheFile") {
  const ScratchDirectory in;
  write_text(in / "scan.xyz", "0 0 0\n1 0 0\n0 1 0\n1 1 0\n");
  const auto result = run_program(
      {"reconstruct", "scan.xyz", "-o", "mesh.ply", "--normals", "file"}, {.directory = in.path()});
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("scan.xyz") && Contains("normals"));
  check_no_mesh(in);
}

TEST_CASE("AJobFileThatCannotBeOpenedHasTheSystemsReason") {
  const ScratchDirectory in;
  std::filesystem::create_directory(in / "folder.toml");
  for (const auto& [file, reason] : {std::pair("nope.toml", "No such file or directory"),
                                     std::pair("folder.toml", "Is a directory")}) {
    const auto result = run_in(in, {"run", file});
    CHECK(result.status == 2);
    CHECK_THAT(result.err, Contains(std::string(file) + ": cannot open the job file: " + reason));
  }
}

TEST_CASE("UnknownKeyInTheJobFileGetsTheNearestOne") {
  const ScratchDirectory in;
  write_text(in / "job.toml",
             "[input]\nfiles = [\"scan.ply\"]\n[reconstruct]\nball_radius = 1.0\n"
             "[output]\nmesh = \"mesh.ply\"\n");
  const auto result = run_program({"run", "job.toml"}, {.directory = in.path()});
  CHECK(result.status == 2);
  CHECK_THAT(result.err,
             Contains("job.toml: line 4") && Contains("ball_radius") && Contains("ball_radii"));
  check_no_mesh(in);
}

TEST_CASE("UnknownKeyOnTheCommandLineGetsTheNearestOne") {
  const ScratchDirectory in;
  write_text(in / "job.toml", "[input]\nfiles = [\"scan.ply\"]\n[output]\nmesh = \"mesh.ply\"\n");
  const auto result = run_program({"run", "job.toml", "--set", "partition.chunkpoints=5"},
                                  {.directory = in.path()});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains("chunkpoints") && Contains("chunk_points"));
}

TEST_CASE("ARunSaysInShortLinesWhatItChose", "[costly]") {
  const ScratchDirectory in;
  generate_noisy(in, "scan.ply");
  const auto result = reconstruct(in, "scan.ply", {"--report", "report.json", "--levels", "3"});
  CHECK(result.status == 0);
  CHECK_THAT(result.err, Contains("\nball radii 0.") && Contains(" (3 levels), 1.1 to 2.4") &&
                             Contains(" times the point spacing 0.") &&
                             Contains("\nnormals: estimated, oriented by propagation; "));
  CHECK_THAT(result.err, !Contains("the mean distance to the") && !Contains("neighbours within"));
  CHECK_THAT(file_text(in / "report.json"),
             Contains("the mean distance to the") && Contains("neighbours within"));
}

TEST_CASE("TheShareOfUncertainPatchesIsSaidWithWhatToCheck", "[costly]") {
  const ScratchDirectory in;
  generate_noisy(in, "scan.ply", "1.2");
  const auto result = reconstruct(in, "scan.ply", {"--no-fill"});
  CHECK(result.status == 0);
  CHECK_THAT(result.err, Contains("oriented by propagation; ") &&
                             Contains(" % of the patches uncertain: check for flipped areas\n"));
}

TEST_CASE("AdviceNamesTheOptionOfACommandLineAndTheKeyOfAJobFile", "[costly]") {
  const ScratchDirectory in;
  generate_noisy(in, "scan.ply");
  const auto by_options = reconstruct(in, "scan.ply");
  CHECK_THAT(by_options.err,
             Contains("; above 9 %: the mesh may be rough or have holes; try --cleaning\n"));
  write_text(in / "job.toml", "[input]\nfiles = [\"scan.ply\"]\n[output]\nmesh = \"other.ply\"\n");
  const auto by_file = run_program({"run", "job.toml"}, {.directory = in.path()});
  CHECK_THAT(by_file.err, Contains("; try cleaning.auto = true\n") && !Contains("--cleaning"));
  const auto limited = reconstruct(in, "scan.ply", {"--max-diameter", "1e-6"});
  CHECK_THAT(limited.out, Contains("wider than --max-diameter\n"));
  const auto wrong = reconstruct(in, "scan.ply", {"--levels", "9"});
  CHECK(wrong.status == 2);
  CHECK_THAT(wrong.err, Contains("error: --levels has an unsuitable value"));
  const auto wrong_key =
      run_program({"run", "job.toml", "--set", "reconstruct.levels=9"}, {.directory = in.path()});
  CHECK_THAT(wrong_key.err, Contains("error: reconstruct.levels has an unsuitable value"));
}

TEST_CASE("RadiusFarTooSmallIsBadInputThatComparesItWithTheSpacing") {
  const ScratchDirectory in;
  generate(in, "torus", "2000", "scan.ply");  // about 0.089 apart
  const auto result = reconstruct(in, "scan.ply", {"--radii", "0.0003"});
  CHECK(result.status == 3);
  CHECK_THAT(result.err,
             Contains("ball radius 0.0003, 0.003") && Contains("times the point spacing"));
  check_no_mesh(in);
}

TEST_CASE("RadiusFarTooLargeIsWrongUsageThatComparesItWithTheSpacing") {
  const ScratchDirectory in;
  generate(in, "torus", "2000", "scan.ply");
  const auto result = reconstruct(in, "scan.ply", {"--radii", "27"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains("ball radius 27, 2") && Contains("times the point spacing"));
  check_no_mesh(in);
}

TEST_CASE("RiddledMeshIsWrittenWithAWarningThatSaysWhy") {
  const ScratchDirectory in;
  generate(in, "torus", "2000", "scan.ply");
  const auto result =
      reconstruct(in, "scan.ply", {"--radii", "0.06", "--no-fill", "--report", "report.json"});
  CHECK(result.status == 0);
  CHECK_THAT(result.err, Contains("riddled with holes") && Contains("times the point spacing"));
  CHECK_THAT(file_text(in / "report.json"), Contains("riddled with holes"));
  CHECK(std::filesystem::exists(in / "mesh.ply"));
}

TEST_CASE("OutputThatCannotBeWrittenIsAResourceErrorBeforeAnyWork") {
  const ScratchDirectory in;
  generate(in, "sphere", "1000", "scan.ply");
  write_text(in / "file", "");
  const std::string out = GENERATE("nowhere/mesh.ply", "file/mesh.ply");
  CAPTURE(out);
  const auto result = run_program({"reconstruct", "scan.ply", "-o", out}, {.directory = in.path()});
  CHECK(result.status == 4);
  CHECK_THAT(result.err, Contains("orbweave: error: ") && Contains(out));
  CHECK(!std::filesystem::exists(in / "nowhere"));
}

TEST_CASE("UnwritableKindsAndPlacesAreFoundBeforeAnyWork") {
  struct Case {
    std::vector<std::string> arguments;
    int status;
    const char* fragment;
  };
  const Case given = GENERATE(values<Case>(
      {{{"-o", "mesh.foo"},
        2,
        "mesh.foo: cannot write .foo meshes; supported: .ply[.gz], .obj, .stl, .glb, .vtp or "
        ".xdmf"},
       {{"-o", "mesh.obj", "--format", "binary"}, 2, "mesh.obj: OBJ has no binary encoding"},
       {{"-o", "mesh.ply", "--report", "no/r.json"},
        4,
        "no/r.json: the report cannot be written there"},
       {{"-o", "mesh.ply", "--picture", "no/p.png"},
        4,
        "no/p.png: the picture cannot be written there"},
       {{"-o", "./scan.ply"}, 2, "would replace a scan"}}));
  const ScratchDirectory in;
  generate(in, "sphere", "1000", "scan.ply");
  const std::string before = file_text(in / "scan.ply");
  std::vector<std::string> arguments = {"reconstruct", "scan.ply"};
  arguments.insert(arguments.end(), given.arguments.begin(), given.arguments.end());
  const auto result = run_program(arguments, {.directory = in.path()});
  CHECK(result.status == given.status);
  CHECK_THAT(result.err, Contains(given.fragment) && !Contains("begins"));
  CHECK(file_text(in / "scan.ply") == before);
  check_no_mesh(in);
}

TEST_CASE("ScansFromStandardInputAreWrongUsageWithAWayOut") {
  const ScratchDirectory in;
  const std::vector<std::vector<std::string>> commands = {{"reconstruct", "-", "-o", "mesh.ply"},
                                                          {"plan", "-"}};
  for (const std::vector<std::string>& command : commands) {
    const ProgramResult refused = run_in(in, command);
    CHECK(refused.status == 2);
    CHECK(refused.err ==
          "orbweave: error: a job reads its scans several times and takes none from standard "
          "input. Write a file first: orbweave convert - scan.ply\n");
    check_no_mesh(in);
  }
  generate(in, "sphere", "500", "sphere.ply");
  const auto way_out = run_program({"-c",
                                    "\"$0\" convert - scan.ply <sphere.ply && "
                                    "\"$0\" reconstruct scan.ply -o mesh.ply --progress none",
                                    program_path().string()},
                                   {.directory = in.path(), .program = "/bin/sh"});
  CHECK(way_out.status == 0);
  CHECK(std::filesystem::exists(in / "mesh.ply"));
}

TEST_CASE("AReaderThatClosesThePipeLeavesNoWorkDirectory") {
  const ScratchDirectory in;
  generate(in, "sphere", "20000", "scan.ply");
  const auto result =
      run_program({"-c", "\"$0\" reconstruct scan.ply -o - --progress none | head -c 10 > ten",
                   program_path().string()},
                  {.directory = in.path(), .program = "/bin/sh"});
  CHECK_THAT(result.err, Contains("standard output: the reader has closed the pipe. Write to a "
                                  "file to keep the whole\n"));
  CHECK(names_in(in) == std::vector<std::string>{"scan.ply", "ten"});
}

TEST_CASE("WhatIsMeantForAClosedStreamReachesNoFile") {
  const ScratchDirectory in;
  generate(in, "sphere", "2000", "scan.ply");
  const std::vector<std::string> job = {
      "reconstruct", "scan.ply",        "-o",         "-",   "--work-dir",
      "work",        "--keep-work-dir", "--progress", "none"};
  for (const char* closed : {"exec >&-", "exec <&- >&-", "exec >&- 2>&-"}) {
    INFO(closed);
    CHECK(run_limited(in, closed, job).status == 4);
    CHECK(file_text(in / "work" / "lock").find("ply") == std::string::npos);
  }
  CHECK_THAT(run_limited(in, "exec >&-", job).err, Contains("standard output: cannot write"));
  const auto resumed = run_in(in, job);
  CHECK(resumed.status == 0);
  CHECK(resumed.out.starts_with("ply\n"));
}
