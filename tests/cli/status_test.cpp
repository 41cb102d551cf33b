// `orbweave status` beside a running job, after a killed one and after one that ended; and a second
// process on the same work directory.
#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <map>
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
using test::run_program;
using test::RunningProgram;
using test::ScratchDirectory;

ProgramResult run_in(const ScratchDirectory& in, const std::vector<std::string>& arguments) {
  return run_program(arguments, {.directory = in.path()});
}

/// A job of some hundred chunks.
const std::vector<std::string> kCommand = {
    "reconstruct", "scan.ply", "-o", "mesh.ply", "--threads", "1", "--chunk-points", "1500"};

void make_scan(const ScratchDirectory& in) {
  REQUIRE(run_in(in, {"generate", "torus", "--points", "100000", "-o", "scan.ply"}).status == 0);
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

/// Lets the job run for a few milliseconds at a time, however slow everything else is, until some
/// chunks have their meshes; it is stopped (SIGSTOP) then. Returns its status.
json stopped_in_the_middle(const ScratchDirectory& in, RunningProgram& program, Growth& growth) {
  while (program.running()) {
    program.send(SIGSTOP);
    if (test::results_in(in / "mesh.work" / "mesh") > 2) {
      const json status = status_of(in);
      growth.check(status);
      if (in_the_middle_of_the_mesh(status)) return status;
    }
    program.send(SIGCONT);
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
  return {};
}

}  // namespace

TEST_CASE("StatusOfARunningJobSaysWhatItIsAtAndWhoRunsIt") {
  const ScratchDirectory in;
  make_scan(in);
  RunningProgram program(kCommand, {.directory = in.path()});
  Growth growth;
  const json status = stopped_in_the_middle(in, program, growth);
  REQUIRE(in_the_middle_of_the_mesh(status));
  CHECK(status["running"] == true);
  CHECK(status["ended"] == false);
  CHECK(std::to_string(status["process_id"].get<int>()) + "\n" ==
        file_text(in / "mesh.work" / "lock"));
  CHECK(status["step"] == "reconstruct");
  CHECK(stage_of(status, "points")["done"] == true);
  const std::uint64_t before = stage_of(status, "mesh")["chunks_done"];

  program.send(SIGKILL);
  REQUIRE(program.wait().status == 128 + SIGKILL);
  const json after = status_of(in);
  CHECK(after["running"] == false);
  CHECK(after["process_id"] == status["process_id"]);
  CHECK(after["step"] == "reconstruct");
  CHECK(stage_of(after, "mesh")["chunks_done"] >= before);
  CHECK(stage_of(after, "mesh")["done"] == false);
  CHECK_THAT(run_in(in, {"status", "mesh.work"}).out, Contains("not in use; last by process") &&
                                                          Contains("was at") &&
                                                          Contains("reconstruct"));
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

TEST_CASE("ASecondProcessIsRefusedAndTheFirstGoesOnUnharmed") {
  const ScratchDirectory in;
  const ScratchDirectory undisturbed;
  make_scan(in);
  std::filesystem::copy_file(in / "scan.ply", undisturbed / "scan.ply");
  RunningProgram first(kCommand, {.directory = in.path()});
  Growth growth;
  REQUIRE(in_the_middle_of_the_mesh(stopped_in_the_middle(in, first, growth)));
  const std::string process = file_text(in / "mesh.work" / "lock");
  for (const char* fresh : {"", "--fresh"}) {
    std::vector<std::string> command = kCommand;
    if (*fresh != '\0') command.push_back(fresh);
    const ProgramResult second = run_in(in, command);
    CHECK(second.status == 4);
    CHECK_THAT(second.err, Contains("in use by process " + process.substr(0, process.size() - 1)));
  }
  first.send(SIGCONT);
  while (first.running()) {
    const json status = status_of(in);
    if (!removal_has_begun(in / "mesh.work")) growth.check(status);
  }
  const ProgramResult ended = first.wait();
  INFO(ended.err);
  CHECK(ended.status == 0);
  REQUIRE(run_in(undisturbed, kCommand).status == 0);
  CHECK((file_text(in / "mesh.ply") == file_text(undisturbed / "mesh.ply")));
  CHECK(!std::filesystem::exists(in / "mesh.work"));
}

}  // namespace orbweave
