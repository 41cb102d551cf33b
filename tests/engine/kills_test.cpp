// The real program, killed in every stage: the same command goes on, and ends as if nothing had
// been.
#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::file_text;
using test::names_in;
using test::ProgramResult;
using test::run_program;
using test::RunningProgram;
using test::ScratchDirectory;

[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

constexpr const char* kJob = R"([input]
files = ["scan_*.ply"]
poses = "scan.conf"
[partition]
chunk_points = 600
[cleaning]
outlier_sigma = 6.0
merge_tolerance = 0.004
smooth_radius = 0.12
thin_to_spacing = 0.02
[normals]
source = "estimate"
orientation = "propagate"
[reconstruct]
ball_radii = [0.04, 0.06]
[output]
mesh = "mesh.ply"
report = "report.json"
picture = "mesh.png"
[run]
threads = 2
work_dir = "work"
)";
const std::vector<std::string> kCommand = {"run", "job.toml", "--progress", "none"};

void make_scans(const fs::path& directory) {
  const ProgramResult made = run_program({"generate", "torus", "--points", "6000", "--scans", "4",
                                          "--noise", "0.2", "--separate", "-o", "scan.ply"},
                                         {.directory = directory});
  REQUIRE(made.status == 0);
  test::write_text(directory / "job.toml", kJob);
}

/// Committed results and documents, by name below the work directory, with the times they were
/// written; a result that is made again has another.
std::map<std::string, fs::file_time_type> committed_in(const fs::path& work) {
  std::map<std::string, fs::file_time_type> found;
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(work, ignored)) {
    const std::string name = entry.path().filename().string();
    const bool document = name == "partition.json.xxh3" || name == "ended.json.xxh3";
    if ((name.ends_with(".h5") && !name.starts_with(".")) || document)
      found[fs::relative(entry.path(), work).string()] = entry.last_write_time(ignored);
  }
  return found;
}

/// Starts the job and kills it soon after its log says that `step` begins. False: it ended before.
bool kill_in_step(const fs::path& in, const std::string& step, std::uint64_t moments) {
  const fs::path log = in / "work" / "orbweave.log";
  const std::size_t old = file_text(log).size();
  RunningProgram program(kCommand, {.directory = in});
  const auto begun = [&] {
    if (step == "start") return true;
    if (step == "removal") return fs::exists(in / "work" / "ended.json");
    const std::string text = file_text(log);
    return text.size() > old && text.find(" info " + step + ": begins", old) != std::string::npos;
  };
  if (program.hold_when(begun)) {
    while (moments-- > 0) program.run_a_moment();
    program.send(SIGKILL);
  }
  const ProgramResult result = program.wait();
  if (result.status == 128 + SIGKILL) return true;
  INFO(result.err);
  REQUIRE(result.status == 0);
  return false;
}

/// What was committed is there untouched, or its stage is over and its results were removed.
void check_kept(const std::map<std::string, fs::file_time_type>& before, const fs::path& work) {
  const auto now = committed_in(work);
  for (const auto& [name, time] : before) {
    const auto found = now.find(name);
    INFO(name);
    if (found != now.end()) CHECK(found->second == time);
    const bool raw = name.starts_with("raw");
    if (found == now.end() && !raw && fs::exists(work))
      CHECK(fs::exists(work / "ended.json"));  // everything is on its way out
  }
}

TEST_CASE("KilledInAnyStageTheSameCommandEndsWithTheSameBytesAndRepeatsNothingCommitted") {
  const ScratchDirectory undisturbed;
  const ScratchDirectory in;
  make_scans(undisturbed.path());
  make_scans(in.path());
  REQUIRE(run_program(kCommand, {.directory = undisturbed.path()}).status == 0);
  const std::vector<std::string> expected = names_in(undisturbed);
  REQUIRE(std::binary_search(expected.begin(), expected.end(), "mesh.ply"));
  REQUIRE_FALSE(std::binary_search(expected.begin(), expected.end(), "work"));

  std::mt19937_64 random(5);
  // Never backwards, so that every step is reached in the round that it is in.
  const std::vector<std::vector<std::string>> rounds = {
      {"start", "raw sort", "raw_outliers", "raw_normals", "raw_smooth_1", "raw_patches"},
      {"raw_merged", "raw_thinned", "sort", "reconstruct", "reconstruct", "holes"},
      {"count", "export", "picture", "removal"}};
  // Once through is enough, unless a busy machine lets the job end before it is killed.
  int kills = 0;
  constexpr std::size_t kMostRounds = 12;
  for (std::size_t r = 0; r < rounds.size() || (kills < 12 && r < kMostRounds); ++r) {
    const std::vector<std::string>& round = rounds[r % rounds.size()];
    for (const std::string& step : round) {
      const auto before = committed_in(in / "work");
      INFO(step << " after " << kills << " kills");
      kills += kill_in_step(in.path(), step, random() % 12) ? 1 : 0;
      check_kept(before, in / "work");
    }
    const ProgramResult last = run_program(kCommand, {.directory = in.path()});
    INFO(last.err);
    REQUIRE(last.status == 0);
    CHECK((file_text(in / "mesh.ply") == file_text(undisturbed / "mesh.ply")));
    CHECK((file_text(in / "mesh.png") == file_text(undisturbed / "mesh.png")));
    CHECK(names_in(in) == expected);
    for (const char* name : {"mesh.ply", "mesh.png", "report.json", "report.html"})
      fs::remove(in / name);
  }
  CHECK(kills >= 12);
}

}  // namespace
}  // namespace orbweave
