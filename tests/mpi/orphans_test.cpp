// Members that outlive their leader: nobody else works in the directory until they have ended.
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <thread>

#include "io/store/store_lock.h"
#include "tests/mpi/mpi_jobs.h"

using Catch::Matchers::Contains;
using namespace orbweave::test;

namespace {

namespace fs = std::filesystem;
using Job = std::vector<std::string>;

/// The process that wrote its number into the file; 0: none has yet.
pid_t process_in(const fs::path& lock) {
  pid_t process = 0;
  std::ifstream(lock) >> process;
  return process;
}

/// Holds a job of two ranks still while both are at work and kills all of it but rank 1, which
/// is returned, still held; 0 where the job was over before.
pid_t orphan_a_member(const ScratchDirectory& in, const Job& job) {
  const fs::path work = in / "mesh.work";
  RunningProgram mpirun(by_ranks(2, job), mpi_setting(in.path()));
  const fs::path lock = work / "member.1";
  // The number stays in the file when the member has done its part.
  std::vector<pid_t> others = hold_ranks_when(
      mpirun, 2, [&] { return process_in(lock) != 0 && !orbweave::members_at_work(work).empty(); });
  if (others.empty()) return 0;
  const pid_t member = process_in(lock);
  std::erase(others, member);
  mpirun.send(SIGKILL);
  mpirun.wait();
  kill_all(others);
  return member;
}

/// Inherits what orphan_a_member() leaves. Otherwise it would fall to a process outside of the
/// session, and the system would not leave it held: it hangs up on held orphans.
void adopt_orphans() { REQUIRE(prctl(PR_SET_CHILD_SUBREAPER, 1) == 0); }

/// Waits for an adopted process, five minutes at the most.
bool ends_by_itself(pid_t process) {
  for (int tries = 0; tries < 3000; ++tries) {
    if (waitpid(process, nullptr, WNOHANG) == process) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return false;
}

}  // namespace

TEST_CASE("MemberThatOutlivesItsLeaderKeepsOthersOutUntilItEndsByItself", "[soak]") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 20000);
  const std::string expected = mesh_of_one(in, job);
  adopt_orphans();
  const int ranks = GENERATE(1, 2);
  const auto again = [&] {
    return ranks == 1 ? run_program(job, {.directory = in.path()})
                      : run_by_ranks(ranks, job, in.path());
  };
  pid_t member = 0;
  for (int runs = 0; member == 0 && runs < 8; ++runs) {
    member = orphan_a_member(in, job);
    std::filesystem::remove(in / "mesh.ply");
  }
  REQUIRE(member != 0);
  const ProgramResult refused = again();
  const ProgramResult status = run_program({"status", "mesh.work"}, {.directory = in.path()});
  kill(member, SIGCONT);
  const std::string name = "rank 1 (process " + std::to_string(member) + " on ";
  CHECK(refused.status == 4);
  CHECK_THAT(refused.err, Contains(name));
  CHECK_THAT(status.out, Contains(name));
  CHECK_FALSE(std::filesystem::exists(in / "mesh.ply"));
  REQUIRE(ends_by_itself(member));
  const ProgramResult result = again();
  INFO(result.err);
  REQUIRE(result.status == 0);
  CHECK(take_mesh(in) == expected);
  CHECK_FALSE(std::filesystem::exists(in / "mesh.work"));
}
