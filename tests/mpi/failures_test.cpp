// What ends a job of several processes is told once, with the status that one process has.
#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <optional>
#include <thread>

#include "tests/mpi/mpi_jobs.h"

using Catch::Matchers::Contains;
using namespace orbweave::test;

namespace {

using Job = std::vector<std::string>;

bool appears(const std::filesystem::path& path, RunningProgram& program) {
  while (!std::filesystem::exists(path)) {
    if (!program.running()) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return program.running();
}

/// Signals both ranks before any hole is looked at, as a batch system does. The ranks are held
/// still meanwhile: nobody can finish. Nothing where they were too fast to be held.
std::optional<ProgramResult> run_and_signal_ranks(const ScratchDirectory& in, const Job& job,
                                                  int signal) {
  const std::filesystem::path work = in / "mesh.work";
  RunningProgram mpirun(by_ranks(2, job), mpi_setting(in.path()));
  const std::vector<pid_t> ranks = hold_ranks_when(
      mpirun, 2, [&] { return exists(work / "points") && !exists(work / "holes"); });
  signal_all(ranks, signal);
  signal_all(ranks, SIGCONT);
  const ProgramResult result = mpirun.wait();
  if (!ranks.empty()) return result;
  std::filesystem::remove(in / "mesh.ply");
  return std::nullopt;
}

}  // namespace

TEST_CASE("WhatAllRanksFindWrongIsToldOnceAsByOneProcess") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = {"reconstruct", "absent.ply", "-o", "mesh.ply"};
  const ProgramResult one = run_program(job, {.directory = in.path()});
  const ProgramResult three = run_by_ranks(3, job, in.path());
  CHECK(one.status > 0);
  CHECK(three.status == one.status);
  CHECK(count_of(three.err, "orbweave: error: ") == 1);
  CHECK_THAT(three.err, Contains(one.err));
}

TEST_CASE("WhatIsMeantForAClosedStreamReachesNoFileOfATeam") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "2000", "-o", "scan.ply"}).status == 0);
  ProgramSetting shell = mpi_setting(in.path());
  shell.program = "/bin/sh";
  const std::string job = " reconstruct scan.ply -o - --keep-work-dir --work-dir work >&-";
  CHECK(run_program({"-c", ORBWEAVE_MPI_PROGRAM + job}, shell).status == 4);
  CHECK(file_text(in / "work" / "lock").find("ply") == std::string::npos);
}

TEST_CASE("NobodyIsToldToRemoveADirectoryOfTheUsers") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  std::filesystem::create_directory(in / "mine");
  write_text(in / "broken.ply",
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
             "property float y\nproperty float z\nend_header\n1 2\n");
  const char* scan = GENERATE("absent.ply", "broken.ply");
  const ProgramResult result =
      run_by_ranks(2, {"reconstruct", scan, "-o", "mesh.ply", "--work-dir", "mine"}, in.path());
  CAPTURE(result.err);
  CHECK(result.status == 3);
  CHECK_THAT(result.err, !Contains("remove it"));
  CHECK(std::filesystem::is_directory(in / "mine"));
}

TEST_CASE("UnknownCommandIsToldOnceWithTheCommandsThatATeamHas") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const ProgramResult result = run_by_ranks(3, {"inspect"}, in.path());
  CHECK(result.status == 2);
  CHECK(count_of(result.err, "orbweave: error: ") == 1);
  CHECK_THAT(result.err, Contains("run, reconstruct"));
}

TEST_CASE("WhatOneRankFindsWrongNamesItAndEndsTheJob") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  write_text(in / "cloud.xyz", "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 x 0 0 1\n");
  const Job job = {"reconstruct", "cloud.xyz", "-o", "mesh.ply", "--progress", "none"};
  const ProgramResult result = run_by_ranks(3, job, in.path());
  CHECK(result.status == 3);
  CHECK(count_of(result.err, "orbweave: error: ") == 1);
  CHECK_THAT(result.err, Contains("orbweave: error: rank ") && Contains("cloud.xyz: line 3"));
  CHECK_THAT(result.err, Contains("The work directory mesh.work stays; remove it."));
  CHECK(names_in(in) == std::vector<std::string>{"cloud.xyz", "mesh.work"});
}

TEST_CASE("WhatSeveralRanksFindWrongIsToldOnce") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  oriented_job(in, 3000);
  const Job job = {"reconstruct", "cloud.ply", "-o", "mesh.ply", "--radii", "1e6"};
  for (int runs = 0; runs < 4; ++runs) {
    const ProgramResult result = run_by_ranks(3, job, in.path());
    INFO(result.err);
    CHECK(result.status == 2);
    CHECK(count_of(result.err, "orbweave: error: ") == 1);
    CHECK_THAT(result.err, Contains("the ball radius is too large") && !Contains("interrupted"));
  }
}

TEST_CASE("RanksThatWereGivenDifferentJobsMakeNoMesh") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 2000);
  const Job other = GENERATE(Job{"--kernel", "triharmonic"}, Job{"--precision", "float"},
                             Job{"--format", "text"}, Job{"--every", "17"});
  const ProgramResult result =
      run_program(by_ranks(1, job) + Job{":"} + by_ranks(1, job + other), mpi_setting(in.path()));
  INFO(result.err);
  CHECK(result.status == 2);
  CHECK(count_of(result.err, "orbweave: error: ") == 1);
  CHECK_THAT(result.err, Contains("the ranks were given different jobs") &&
                             Contains("from rank 0 to rank 1") && Contains(other[1]));
  CHECK(names_in(in) == std::vector<std::string>{"cloud.ply"});
}

TEST_CASE("BudgetAndThreadsAreEveryRanksOwn") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 2000);
  const std::string mesh = mesh_of_one(in, job);
  const Job first = job + Job{"--memory", "512MiB", "--threads", "1"};
  const Job second = job + Job{"--memory", "1GiB", "--threads", "2"};
  const ProgramResult result =
      run_program(by_ranks(1, first) + Job{":"} + by_ranks(1, second), mpi_setting(in.path()));
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(take_mesh(in) == mesh);
}

TEST_CASE("WorkDirectoryThatIsNotSharedIsNoticed", "[soak]") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  Job job = oriented_job(in, 3000);
  const bool of_an_earlier_run = GENERATE(false, true);
  // A relative name means another directory to the second rank, as a local disk would.
  job = job + Job{"--work-dir", "work"};
  job[1] = (in / "cloud.ply").string();
  std::filesystem::create_directory(in / "elsewhere");
  if (of_an_earlier_run) {
    REQUIRE(run_by_ranks(2, job + Job{"--keep-work-dir"}, in / "elsewhere").status == 0);
  }
  const Job first = by_ranks(1, job);
  Job second = by_ranks(1, job);
  second.insert(second.begin(), {"--wdir", (in / "elsewhere").string()});
  const ProgramResult result = run_program(first + Job{":"} + second, mpi_setting(in.path()));
  INFO(result.err);
  CHECK(result.status == 4);
  CHECK(count_of(result.err, "orbweave: error: ") == 1);
  CHECK_THAT(result.err, Contains("rank 1 (") && Contains("shared file system"));
}

TEST_CASE("InterruptedJobOfSeveralRanksSaysOnceThatItResumesAndDoes") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 20000);
  const std::string expected = mesh_of_one(in, job);
  const int signal = GENERATE(SIGINT, SIGTERM);
  std::optional<ProgramResult> result;
  for (int runs = 0; !result && runs < 8; ++runs) result = run_and_signal_ranks(in, job, signal);
  REQUIRE(result);
  CHECK(result->status == 130);
  CHECK(count_of(result->err, "orbweave: error: ") == 1);
  CHECK_THAT(result->err, Contains("mesh.work") && Contains("the same command resumes"));
  CHECK_FALSE(std::filesystem::exists(in / "mesh.ply"));
  REQUIRE(run_by_ranks(2, job, in.path()).status == 0);
  CHECK(take_mesh(in) == expected);
}

TEST_CASE("JobWhoseMpirunIsInterruptedResumesToTheSameMesh", "[soak]") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 20000);
  const std::string expected = mesh_of_one(in, job);
  const int signal = GENERATE(SIGINT, SIGTERM);
  RunningProgram mpirun(by_ranks(2, job), mpi_setting(in.path()));
  if (appears(in / "mesh.work" / "points", mpirun)) mpirun.send(signal);
  mpirun.wait();
  // mpirun passes the signal on a second late: a quick job is done by then, whatever mpirun says.
  if (std::filesystem::exists(in / "mesh.ply")) CHECK(take_mesh(in) == expected);
  REQUIRE(run_by_ranks(2, job, in.path()).status == 0);
  CHECK(take_mesh(in) == expected);
}

TEST_CASE("RanksSpeakOfHelpAndVersionOnce") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const ProgramResult help = run_by_ranks(3, {"--help"}, in.path());
  CHECK(help.status == 0);
  CHECK(count_of(help.out, "mpirun -n 8 orbweave-mpi run job.toml") == 1);
  CHECK(count_of(run_by_ranks(2, {"--version"}, in.path()).out, "orbweave-mpi ") == 1);
}
