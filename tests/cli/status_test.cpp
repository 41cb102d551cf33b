// `orbweave status` beside a running job, after a killed one and after one that ended; and a second
// process on the same work directory.
#include <signal.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

using Catch::Matchers::Contains;
using nlohmann::json;
using test::file_text;
using test::ProgramResult;
using test::run_in;
using test::run_program;
using test::RunningProgram;
using test::ScratchDirectory;

[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

/// A job of some hundred chunks.
const std::vector<std::string> kCommand = {
    "reconstruct", "scan.ply", "-o", "mesh.ply", "--threads", "1", "--chunk-points", "500"};

void make_scan(const ScratchDirectory& in) {
  REQUIRE(run_in(in, {"generate", "torus", "--points", "50000", "-o", "scan.ply"}).status == 0);
}

json status_of(const ScratchDirectory& in) {
  const ProgramResult result = run_in(in, {"status", "mesh.work", "--json"});
  // Between the start and the first file there is no work directory yet.
  return result.status == 0 ? json::parse(result.out) : json();
}

json stage_of(const json& status, const std::string& name) {
  if (status.is_object())
    for (const json& stage : status["stages"])
      if (stage["name"] == name) return stage;
  return json::object();
}

/// No stage has more chunks than there are, or fewer than it had.
class Growth {
 public:
  void check(const json& status) {
    if (!status.is_object()) return;
    for (const json& stage : status["stages"]) {
      const std::string name = stage["name"];
      INFO(name);
      const std::uint64_t total = stage["chunks_total"];
      const std::uint64_t committed = stage["chunks_done"];
      if (total > 0) CHECK(committed <= total);
      CHECK(committed >= done_[name]);
      done_[name] = committed;
    }
  }

 private:
  std::map<std::string, std::uint64_t> done_;
};

bool in_the_middle_of_the_mesh(const json& status) {
  const json mesh = stage_of(status, "mesh");
  return mesh.value("chunks_done", 0) > 2 && !mesh.value("done", true);
}

/// Whether the work directory of a job that has ended is being removed, or was: the word that it
/// has ended is written first and goes last.
bool removal_has_begun(const std::filesystem::path& work) {
  return std::filesystem::exists(work / "ended.json") ||
         !std::filesystem::exists(work / "orbweave-store.json");
}

/// The job, held when some chunks have their meshes and others do not, with its status. Results
/// become durable a tenth of a second's worth at a time: the job gets a few milliseconds of that,
/// so that no machine is quick enough to have all of them in one.
struct HeldJob {
  std::unique_ptr<RunningProgram> program;
  json status;
};

HeldJob held_in_the_middle(const ScratchDirectory& in, Growth& growth) {
  constexpr int kMostTries = 20, kPauseMs = 10;
  const std::filesystem::path work = in / "mesh.work";
  HeldJob job;
  const auto in_the_middle = [&] {
    if (test::results_in(work / "mesh") < 3) return false;
    job.status = status_of(in);
    growth.check(job.status);
    return in_the_middle_of_the_mesh(job.status);
  };
  for (int tries = 0; tries < kMostTries; ++tries) {
    growth = {};
    job.program = std::make_unique<RunningProgram>(kCommand, test::ProgramSetting{in.path()});
    if (job.program->hold_when([&] { return std::filesystem::exists(work / "mesh"); }) &&
        job.program->hold_when(in_the_middle, kPauseMs))
      return job;
    REQUIRE(job.program->wait().status == 0);
    std::filesystem::remove(in / "mesh.ply");
  }
  FAIL("the job ends before anybody can look");
  return job;
}

}  // namespace

TEST_CASE("StatusOfARunningJobSaysWhatItIsAtAndWhoRunsIt", "[slow]") {
  const ScratchDirectory in;
  make_scan(in);
  Growth growth;
  const auto [program, status] = held_in_the_middle(in, growth);
  CHECK(status["running"] == true);
  CHECK(status["ended"] == false);
  CHECK_THAT(file_text(in / "mesh.work" / "lock"),
             Catch::StartsWith(std::to_string(status["process_id"].get<int>()) + " (orbweave "));
  CHECK(status["step"] == "reconstruct");
  CHECK(stage_of(status, "points")["done"] == true);
  const double seconds = status["seconds"], left = status["seconds_left"];
  CHECK(seconds > 0.0);
  CHECK(left > 0.0);
  CHECK(status["share"] == Approx(seconds / (seconds + left)));
  CHECK_THAT(run_in(in, {"status", "mesh.work"}).out, Contains(" % after ") && Contains(" left"));
  const std::uint64_t before = stage_of(status, "mesh")["chunks_done"];

  program->send(SIGKILL);
  REQUIRE(program->wait().status == 128 + SIGKILL);
  const json after = status_of(in);
  CHECK(after["running"] == false);
  CHECK(after["process_id"] == status["process_id"]);
  CHECK(after["step"] == "reconstruct");
  CHECK(!after.contains("share"));
  CHECK(stage_of(after, "mesh")["chunks_done"] >= before);
  CHECK(stage_of(after, "mesh")["done"] == false);
  CHECK_THAT(run_in(in, {"status", "mesh.work"}).out,
             Contains("not in use; last by process") && Contains("was at") &&
                 Contains("stopped before its end") && Contains("reconstruct"));
}

TEST_CASE("StatusOfAKeptWorkDirectorySaysThatTheJobHasEnded") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "5000", "-o", "scan.ply"}).status == 0);
  REQUIRE(run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.ply", "--keep-work-dir"}).status == 0);
  const json status = status_of(in);
  CHECK(status["ended"] == true);
  CHECK(status["running"] == false);
  for (const json& stage : status["stages"]) CHECK(stage["done"] == true);
  CHECK_THAT(run_in(in, {"status", "mesh.work"}).out, Contains("all outputs are written"));
}

TEST_CASE("ASecondProcessIsRefusedAndTheFirstGoesOnUnharmed", "[slow]") {
  const ScratchDirectory in;
  const ScratchDirectory undisturbed;
  make_scan(in);
  std::filesystem::copy_file(in / "scan.ply", undisturbed / "scan.ply");
  Growth growth;
  const HeldJob held = held_in_the_middle(in, growth);
  RunningProgram& first = *held.program;
  const std::string process = file_text(in / "mesh.work" / "lock");
  for (const char* fresh : {"", "--fresh"}) {
    std::vector<std::string> command = kCommand;
    if (*fresh != '\0') command.push_back(fresh);
    const ProgramResult second = run_in(in, command);
    CHECK(second.status == 4);
    CHECK_THAT(second.err, Contains("in use by process " + process.substr(0, process.find(' '))));
  }
  first.release();
  constexpr std::chrono::milliseconds kBetweenLooks{20};
  while (first.running()) {
    const json status = status_of(in);
    if (!removal_has_begun(in / "mesh.work")) growth.check(status);
    std::this_thread::sleep_for(kBetweenLooks);
  }
  const ProgramResult ended = first.wait();
  INFO(ended.err);
  CHECK(ended.status == 0);
  REQUIRE(run_in(undisturbed, kCommand).status == 0);
  CHECK((file_text(in / "mesh.ply") == file_text(undisturbed / "mesh.ply")));
  CHECK(!std::filesystem::exists(in / "mesh.work"));
}

TEST_CASE("TheBenchmarksReadTheProgramsTableOfStages") {
  const ScratchDirectory in;
  const ProgramResult result = run_in(in, {"status", "--stages", "--json"});
  CHECK(result.status == 0);
  CHECK(result.out == file_text(test::source_path("bench/models/stages.json")));
  const json stages = json::parse(result.out)["stages"];
  CHECK(stages.size() == 32);
  CHECK_THAT(run_in(in, {"status", "--stages"}).out, Contains("reconstruct") && Contains("holes"));
}

TEST_CASE("StatusOfNoWorkDirectoryIsRefused") {
  const ScratchDirectory in;
  const ProgramResult result = run_in(in, {"status"});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains("names no work directory") && Contains("WORK_DIR"));
}

TEST_CASE("StatusSaysWhyAPlaceIsNoWorkDirectory") {
  const ScratchDirectory in;
  test::write_text(in / "file", "");
  const auto told = [&](const std::string& name) {
    const ProgramResult result = run_in(in, {"status", name});
    CHECK(result.status == 2);
    CHECK_THAT(result.err, Contains("is no work directory of orbweave"));
    return result.err;
  };
  CHECK_THAT(told("."), Contains("found no orbweave-store.json in it"));
  CHECK_THAT(told("absent"), Contains("found nothing there"));
  CHECK_THAT(told("file"), Contains("found no orbweave-store.json in it"));
  CHECK_THAT(told(std::string(300, 'x')), Contains("found File name too long"));
  std::filesystem::create_symlink("loop", in / "loop");
  CHECK_THAT(told("loop"), Contains("symbolic links"));
}

TEST_CASE("StatusIsToldWhileFoldersOfTheRunComeAndGo") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "2000", "-o", "scan.ply"}).status == 0);
  REQUIRE(run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.ply", "--keep-work-dir"}).status == 0);
  std::atomic<bool> is_over = false;
  std::thread other([&] {
    std::error_code ignored;
    const auto folder = [&](int i) { return in / "mesh.work" / "points" / std::to_string(i); };
    while (!is_over) {
      for (int i = 0; i < 30; ++i) std::filesystem::create_directory(folder(i), ignored);
      for (int i = 0; i < 30; ++i) std::filesystem::remove(folder(i), ignored);
    }
  });
  for (int i = 0; i < 10; ++i) CHECK(run_in(in, {"status", "mesh.work"}).err == "");
  is_over = true;
  other.join();
}

TEST_CASE("StatusReadsWhatTheRunIsAtFromTheLastWholeLineOfItsSteps") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "5000", "-o", "scan.ply"}).status == 0);
  REQUIRE(run_in(in, {"reconstruct", "scan.ply", "-o", "mesh.ply", "--keep-work-dir"}).status == 0);
  const std::filesystem::path steps = in / "mesh.work" / "orbweave-steps.jsonl";
  CHECK(status_of(in)["step"] == "export");
  // A log that says otherwise, or is gone, is nothing to go by.
  std::filesystem::remove(in / "mesh.work" / "orbweave.log");
  std::ofstream(steps, std::ios::app) << "{\"step\": \"picture\", \"total\": 3}\n{\"step\": \"ho";
  CHECK(status_of(in)["step"] == "picture");
  std::filesystem::remove(steps);
  CHECK(status_of(in)["step"] == "");
}

}  // namespace orbweave
