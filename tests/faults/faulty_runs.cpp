#include "tests/faults/faulty_runs.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/program.h"

namespace orbweave::test {
namespace {

namespace fs = std::filesystem;
[[maybe_unused]] const bool in_memory = scratch_in_memory();

constexpr int kResourceStatus = 4;

// Raw scans, little memory for bins, several chunks: all kinds of stored files are written.
constexpr const char* kJob = R"([input]
files = ["scan_*.ply"]
poses = "scan.conf"
[partition]
chunk_points = 400
[cleaning]
merge_tolerance = 0.004
smooth_radius = 0.12
[normals]
source = "estimate"
orientation = "propagate"
[reconstruct]
ball_radii = [0.08, 0.12]
[output]
mesh = "mesh.ply"
report = "report.json"
[run]
threads = 1
work_dir = "work"
)";
const std::vector<std::string> kCommand = {"run", "job.toml", "--progress", "none"};

void make_scans(const fs::path& directory) {
  const ProgramResult made = run_program({"generate", "torus", "--points", "800", "--scans", "2",
                                          "--noise", "0.2", "--separate", "-o", "scan.ply"},
                                         {.directory = directory});
  REQUIRE(made.status == 0);
  write_text(directory / "job.toml", kJob);
}

/// Runs the job with a fault ("KIND:NUMBER:EFFECT"); counts of calls by kind go to `counts`.
ProgramResult run_with_fault(const fs::path& directory, const std::string& fault,
                             std::map<std::string, std::uint64_t>& counts,
                             std::uint64_t seconds_unflushed = 0) {
  const ScratchDirectory elsewhere;
  const fs::path file = elsewhere / "counts";
  std::vector<std::string> environment = {
      "ORBWEAVE_FAULT_COUNTS=" + file.string(),
      "ORBWEAVE_TIME_UNFLUSHED=" + std::to_string(seconds_unflushed)};
  if (!fault.empty()) environment.push_back("ORBWEAVE_FAULT=" + fault);
  const ProgramResult result =
      run_program(kCommand, {.directory = directory,
                             .environment = environment,
                             .program = program_path().parent_path() / "faulty_orbweave"});
  std::istringstream text(file_text(file));
  std::string name;
  for (std::uint64_t count = 0; text >> name >> count;) counts[name] = count;
  return result;
}

/// Whether an error names a place and the system's reason.
bool is_clear(const std::string& error) {
  const bool has_reason = error.find("No space left on device") != std::string::npos ||
                          error.find("Input/output error") != std::string::npos ||
                          error.find("an HDF5 failure") != std::string::npos;
  const bool has_place =
      error.find("work") != std::string::npos || error.find("mesh.ply") != std::string::npos ||
      error.find("scan") != std::string::npos || error.find("job.toml") != std::string::npos ||
      error.find("report.") != std::string::npos;
  return error.find("orbweave: error: ") != std::string::npos && has_reason && has_place;
}

struct Outcome {
  std::uint64_t injected = 0;
  std::uint64_t done = 0;     ///< the run got over it
  std::uint64_t refused = 0;  ///< the run ended in an error, the repeated command did not
};

/// The job with one fault, then once more without.
void try_fault(const fs::path& scans, const std::string& fault, const std::string& expected,
               const std::vector<std::string>& expected_names, Outcome& outcome) {
  const ScratchDirectory in;
  fs::copy(scans, in.path(), fs::copy_options::recursive);
  std::map<std::string, std::uint64_t> counts;
  const ProgramResult faulty = run_with_fault(in.path(), fault, counts);
  INFO(fault << ": status " << faulty.status << "\n" << faulty.err);
  if (counts["injected"] == 0) {
    // Flushes that wait together are one call, so that a run may have fewer than the one before.
    CHECK(faulty.status == 0);
    return;
  }
  ++outcome.injected;
  ++(faulty.status == 0 ? outcome.done : outcome.refused);
  if (faulty.status == 0)
    CHECK((file_text(in / "mesh.ply") == expected));
  else
    CHECK((faulty.status == kResourceStatus && is_clear(faulty.err)));
  const ProgramResult again = run_program(kCommand, {.directory = in.path()});
  INFO("repeated: status " << again.status << "\n" << again.err);
  CHECK(again.status == 0);
  CHECK((file_text(in / "mesh.ply") == expected));
  CHECK(names_in(in) == expected_names);
}

}  // namespace

void try_faults(const std::string& kind, const std::string& effect, std::uint64_t first,
                std::uint64_t step) {
  const ScratchDirectory scans, undisturbed;
  make_scans(scans.path());
  fs::copy(scans.path(), undisturbed.path(), fs::copy_options::recursive);
  std::map<std::string, std::uint64_t> counts;
  REQUIRE(run_with_fault(undisturbed.path(), "", counts).status == 0);
  const std::string expected = file_text(undisturbed / "mesh.ply");
  const std::vector<std::string> names = names_in(undisturbed);
  REQUIRE_FALSE(expected.empty());
  Outcome outcome;
  for (std::uint64_t number = first; number <= counts[kind]; number += step)
    try_fault(scans.path(), kind + ":" + std::to_string(number) + ":" + effect, expected, names,
              outcome);
  std::cout << kind << " (" << effect << "): " << outcome.injected << " faults injected in "
            << counts[kind] << " calls; " << outcome.done << " runs ended well, " << outcome.refused
            << " said why not, and the repeated command ended with the same bytes\n";
  CHECK(outcome.injected > 0);
}

FlushCounts count_flushes(std::uint64_t seconds_unflushed) {
  const ScratchDirectory in;
  make_scans(in.path());
  std::map<std::string, std::uint64_t> counts;
  REQUIRE(run_with_fault(in.path(), "", counts, seconds_unflushed).status == 0);
  const std::uint64_t in_new = counts["sync"];
  // The middle of the writes: stages are there by then.
  const std::string fault = "write:" + std::to_string(counts["write"] / 2) + ":eio";
  REQUIRE(run_with_fault(in.path(), fault, counts, seconds_unflushed).status == kResourceStatus);
  REQUIRE(run_with_fault(in.path(), "", counts, seconds_unflushed).status == 0);
  return {in_new, counts["sync"]};
}

}  // namespace orbweave::test
