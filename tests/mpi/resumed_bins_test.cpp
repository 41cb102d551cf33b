// What a team that was killed has counted and binned, the next run does not count and bin again,
// whoever it is.
#include <signal.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/mpi/mpi_jobs.h"
#include "tests/support/data.h"

using namespace orbweave::test;

namespace {

namespace fs = std::filesystem;
using Job = std::vector<std::string>;

/// Kills a job of three ranks when it has left `document` of the cut, and not `later`. False where
/// that moment was too short to be met with.
bool kill_between(const ScratchDirectory& in, const Job& job, const std::string& document,
                  const std::string& later) {
  const fs::path work = in / "mesh.work";
  RunningProgram mpirun(by_ranks(3, job), mpi_setting(in.path()));
  const auto is_between = [&] {
    return fs::exists(work / "points_cut" / document) && !fs::exists(work / later);
  };
  const std::vector<pid_t> ranks = hold_ranks_when(mpirun, 3, is_between);
  const bool met = !ranks.empty() && is_between();
  if (met) {
    mpirun.send(SIGKILL);
    kill_all(ranks);
  } else {
    signal_all(ranks, SIGCONT);
  }
  mpirun.wait();
  if (!met) take_mesh(in);
  return met;
}

bool kill_in_time(const ScratchDirectory& in, const Job& job, const std::string& document,
                  const std::string& later) {
  constexpr int kMostRuns = 20;
  for (int runs = 0; runs < kMostRuns; ++runs)
    if (kill_between(in, job, document, later)) return true;
  return false;
}

}  // namespace

TEST_CASE("WhatAKilledTeamHasCountedAndBinnedIsNotCountedAndBinnedAgainByOthers", "[soak]") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 20000);
  const std::string expected = mesh_of_one(in, job);
  const bool binned = GENERATE(true, false);
  const int ranks = GENERATE(0, 2, 3);  // 0: one process, which is no team
  INFO((binned ? "binned, " : "counted, ") << ranks << " ranks");
  const std::string cut = "points_cut/";
  const std::string log = (in / "mesh.work" / "orbweave.log").string();
  REQUIRE((binned ? kill_in_time(in, job, "measured.json.xxh3", "points/partition.json")
                  : kill_in_time(in, job, "counted.json.xxh3", cut + "measured.json")));
  const std::size_t old = file_text(log).size();
  const Job kept = job + Job{"--keep-work-dir"};
  const ProgramResult next = ranks == 0 ? run_program(kept, {.directory = in.path()})
                                        : run_by_ranks(ranks, kept, in.path());
  INFO(next.err);
  REQUIRE(next.status == 0);
  CHECK(take_mesh(in) == expected);
  const std::string said = file_text(log).substr(old);
  CHECK(count_of(said, "resuming: the points are counted") == 1);
  CHECK(count_of(said, " info count: begins") == 0);
  CHECK(count_of(said, " info bin: begins") == (binned ? 0 : 1));
  CHECK(count_of(said, " info sort: begins") == 1);
  CHECK_FALSE(fs::exists(in / "mesh.work" / "points_cut"));
}
