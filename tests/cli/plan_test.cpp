// Plans of scans without a job file.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave::test;

namespace {

void write_scan_and_job(const ScratchDirectory& in) {
  REQUIRE(run_in(in, {"generate", "torus", "--points", "3000", "-o", "scan.ply"}).status == 0);
  write_text(in / "job.toml",
             "[input]\nfiles = [\"scan.ply\"]\n[partition]\nchunk_points = 1000\n"
             "[output]\nmesh = \"mesh.ply\"\n");
}

std::size_t files_in(const ScratchDirectory& in) {
  const std::filesystem::directory_iterator files(in.path());
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

/// A sheet so far from the origin that floats would move its points by more than their distance.
std::string far_sheet() {
  std::string text;
  for (int i = 0; i < 900; ++i)
    text += std::to_string(500000.0 + i % 30 * 0.01) + " " +
            std::to_string(5000000.0 + i / 30 * 0.01) + " 0 0 0 1\n";
  return text;
}

/// Every file of a directory, with its content and the time of its last change.
std::map<std::string, std::pair<std::string, std::filesystem::file_time_type>> files_with_times(
    const std::filesystem::path& directory) {
  std::map<std::string, std::pair<std::string, std::filesystem::file_time_type>> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory))
    files[entry.path().string()] = {entry.is_regular_file() ? file_text(entry.path()) : "",
                                    entry.last_write_time()};
  return files;
}

}  // namespace

TEST_CASE("PlanReadsWhatARunHasLeftAndChangesNothingOfIt") {
  const ScratchDirectory in;
  write_scan_and_job(in);
  REQUIRE(run_in(in, {"run", "job.toml", "--keep-work-dir"}).status == 0);
  write_text(in / "mesh.work" / "mesh" / ".000000.h5.part", "cut short");
  const auto before = files_with_times(in.path());
  const auto planned = run_in(in, {"plan", "job.toml"});
  CHECK(planned.status == 0);
  CHECK_THAT(planned.out, Contains("in the mesh of the work directory"));
  CHECK((files_with_times(in.path()) == before));
}

TEST_CASE("PlanRefusesTheJobsThatARunWouldRefuse") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "3000", "-o", "scan.ply"}).status == 0);
  REQUIRE(run_in(in, {"generate", "torus", "--points", "3000", "--scans", "2", "-o", "raw.ply"})
              .status == 0);
  write_text(in / "far.xyz", far_sheet());
  std::filesystem::create_directory(in / "holiday.tiles");
  write_text(in / "holiday.tiles" / "photo.jpg", "a beach");
  write_text(in / "numbers.h5", "another program's");
  write_text(in / "two.xyz", "0 0 0 0 0 1\n1 0 0 0 0 1\n");
  using Arguments = std::vector<std::string>;
  for (const Arguments& job :
       {Arguments{"scan.ply", "-o", "mesh.ply", "--ball-radii", "100"},
        {"scan.ply", "-o", "mesh.ply", "--smooth-radius", "100"},
        {"scan.ply", "-o", "mesh.obj", "--tileset", "tiles"},
        {"scan.ply", "-o", "mesh.ply", "--tiles", "--simplify", "ratio=0.5"},
        {"scan.ply", "-o", "mesh.stl", "--tiles"},
        {"scan.ply", "-o", "holiday.ply", "--tiles"},
        {"scan.ply", "-o", "mesh.ply", "--simplify", "ratio=0.5", "--simplified", "numbers.xdmf"},
        {"far.xyz", "-o", "mesh.stl", "--origin", "none"},
        {"far.xyz", "-o", "mesh.ply", "--origin", "none", "--simplify", "ratio=0.5", "--simplified",
         "small.stl"},
        {"two.xyz", "-o", "mesh.ply"},
        {"raw.ply", "-o", "mesh.ply", "--orientation", "viewpoint"},
        {"raw.ply", "-o", "mesh.ply", "--orientation", "scanner", "--scanner", "auto"}}) {
    CAPTURE(job);
    Arguments run = {"reconstruct", "--progress", "none"};
    Arguments plan = {"plan", "--progress", "none"};
    run.insert(run.end(), job.begin(), job.end());
    plan.insert(plan.end(), job.begin(), job.end());
    const auto refused = run_in(in, run);
    const auto planned = run_in(in, plan);
    CHECK(refused.status != 0);
    CHECK_FALSE(std::filesystem::exists(in / "mesh.ply"));
    CHECK(planned.status == refused.status);
    CHECK(planned.out.empty());
    CHECK_THAT(refused.err, Catch::StartsWith(planned.err.substr(0, planned.err.size() - 1)));
    std::filesystem::remove_all(in / "mesh.work");
  }
}

TEST_CASE("AViewpointThatIsNotGivenIsAskedForBeforeTheWork") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "3000", "--scans", "2", "-o", "raw.ply"})
              .status == 0);
  const auto refused =
      run_in(in, {"reconstruct", "raw.ply", "-o", "mesh.ply", "--orientation", "viewpoint"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err,
             Contains("--orientation viewpoint needs --viewpoint") && !Contains("begins"));
}

TEST_CASE("PlanOfScansIsThatOfTheJobFileThatNamesThem", "[costly]") {
  const ScratchDirectory in;
  write_scan_and_job(in);
  const auto job = run_in(in, {"plan", "job.toml", "--json", "--progress", "none"});
  REQUIRE(job.status == 0);
  const std::string scan = GENERATE("scan.ply", "sca*.ply");
  const auto scans =
      run_in(in, {"plan", scan, "--chunk-points", "1000", "--json", "--progress", "none"});
  INFO(scans.err);
  REQUIRE(scans.status == 0);
  auto expected = nlohmann::json::parse(job.out), planned = nlohmann::json::parse(scans.out);
  CHECK(planned["seconds"] > 0.0);
  // The names are as given; a mesh without a name has no room of its own to be foreseen; the time
  // of the trial varies.
  for (const char* key : {"input", "disk_bytes", "seconds"}) {
    expected.erase(key);
    planned.erase(key);
  }
  CHECK(planned == expected);
  CHECK(files_in(in) == 2);
}

TEST_CASE("PlanSaysLengthsInTheUnitThatTheJobNames") {
  const ScratchDirectory in;
  write_scan_and_job(in);
  const auto planned = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {"plan", "job.toml", "--progress", "none"};
    words.insert(words.end(), more.begin(), more.end());
    const auto result = run_in(in, words);
    INFO(result.err);
    REQUIRE(result.status == 0);
    return result.out;
  };
  CHECK_THAT(planned({}), !Contains(" mm"));
  const std::string metric = planned({"--set", "input.units_per_meter=1"});
  CHECK_THAT(metric, Contains(" mm RMS, ") && Contains(" mm, ") && Contains(" mm); below"));
  const std::string feet = planned({"--set", "input.units_per_meter=3.28083333333"});
  CHECK_THAT(feet, Contains(" ft RMS, ") && Contains(" ft, ") && Contains(" ft); below"));
}

TEST_CASE("PlanTakesAJobFileOrScansButNotBoth") {
  const ScratchDirectory in;
  write_scan_and_job(in);
  const auto result = run_in(in, {"plan", "scan.ply", "job.toml"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains("job.toml") && Contains("a job file or scans, not both"));
}

TEST_CASE("JobFileMayLieInAFolderWhoseNameLooksLikeAPattern") {
  const ScratchDirectory in;
  write_scan_and_job(in);
  std::filesystem::create_directory(in / "torus [1]");
  const std::string job = "torus [1]/job.toml";
  for (const char* file : {"job.toml", "scan.ply"})
    std::filesystem::rename(in / file, in / "torus [1]" / file);
  const std::string command = GENERATE("plan", "run");
  const auto result = run_in(in, {command, job, "--progress", "none"});
  INFO(result.err);
  CHECK(result.status == 0);
}

TEST_CASE("RunSaysThatAScanIsNoJobFile") {
  const ScratchDirectory in;
  write_scan_and_job(in);
  const auto result = run_in(in, {"run", "scan.ply"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains("scan.ply: is a scan") && Contains("orbweave reconstruct"));
}
