// A job comes out the same by any number of processes, however the job ended before.
#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "tests/mpi/mpi_jobs.h"
#include "tests/support/clouds.h"
#include "tests/support/jobs.h"
#include "tests/support/raw_scans.h"

using namespace orbweave::test;

namespace {

using Job = std::vector<std::string>;

void expect_same_bytes(const ScratchDirectory& in, const Job& job) {
  const std::string expected = mesh_of_one(in, job);
  for (const int ranks : {1, 2, 4}) {
    for (const char* threads : {"1", "2"}) {
      INFO(ranks << " ranks, " << threads << " threads");
      const ProgramResult result = run_by_ranks(ranks, job + Job{"--threads", threads}, in.path());
      INFO(result.err);
      REQUIRE(result.status == 0);
      CHECK(count_of(result.out, "triangles") > 0);
      CHECK(count_of(result.out, "mesh.ply") == 1);  // only the leader speaks
      CHECK(take_mesh(in) == expected);
      CHECK_FALSE(std::filesystem::exists(in / "mesh.work"));
    }
  }
}

/// Runs the job with a rank killed when some more results are there; returns whether it was.
bool run_and_kill(const ScratchDirectory& in, const Job& job, Random& random) {
  constexpr std::size_t kRanks = 3;
  const std::filesystem::path work = in / "mesh.work";
  const std::size_t results = results_in(work) + 1 + random.below(8);
  RunningProgram mpirun(by_ranks(kRanks, job), mpi_setting(in.path()));
  const auto ranks = hold_ranks_when(mpirun, kRanks, [&] { return results_in(work) >= results; });
  if (!ranks.empty()) kill(ranks[random.below(ranks.size())], SIGKILL);
  signal_all(ranks, SIGCONT);
  return mpirun.wait().status != 0;  // 0: the rank had done its part
}

void expect_same_bytes_after_kills(const ScratchDirectory& in, const Job& job) {
  const std::string expected = mesh_of_one(in, job);
  Random random(7);
  constexpr int kWanted = 2, kMostRuns = 12;
  int kills = 0;
  for (int runs = 0; kills < kWanted && runs < kMostRuns; ++runs) {
    kills += run_and_kill(in, job, random) ? 1 : 0;
    // The job may end before anybody is killed, or when all was done but the end.
    if (std::filesystem::exists(in / "mesh.ply")) CHECK(take_mesh(in) == expected);
  }
  CHECK(kills == kWanted);
  const ProgramResult result = run_by_ranks(2, job, in.path());
  INFO(result.err);
  REQUIRE(result.status == 0);
  CHECK(take_mesh(in) == expected);
  CHECK_FALSE(std::filesystem::exists(in / "mesh.work"));
}

}  // namespace

TEST_CASE("AnyNumberOfProcessesMakesTheSameMeshOfAnOrientedCloud") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  expect_same_bytes(in, oriented_job(in, 6000));
}

TEST_CASE("AnyNumberOfProcessesMakesTheSameMeshOfRawScans") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  expect_same_bytes(in, raw_job(in, 4000));
}

TEST_CASE("AnyNumberOfProcessesNamesTheScanWithAWrongPose") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const RawScans scans = scan_torus(in, 15000, 0.1, 0.2);
  std::string poses = bytes_of(scans.poses);
  // A scan from above and one from a side, each with the pose of the other.
  for (const auto& [from, to] :
       {std::pair{"scan0.ply", "other"}, std::pair{"scan2.ply", "scan0.ply"},
        std::pair{"other", "scan2.ply"}})
    poses.replace(poses.find(from), std::string(from).size(), to);
  write_text(scans.poses, poses);
  Job job = {"reconstruct", "-o", "mesh.ply", "--poses", scans.poses, "--no-fill"};
  job.insert(job.begin() + 1, scans.files.begin(), scans.files.end());
  std::vector<std::string> warnings;
  for (const int ranks : {1, 3}) {
    const ProgramResult result = run_by_ranks(ranks, job, in.path());
    INFO(result.err);
    REQUIRE(result.status == 0);
    CHECK(count_of(result.err, "does not lie on the surface of the other scans") > 0);
    const std::size_t begin = result.err.find(scans.files[0] + " does not");
    REQUIRE(begin != std::string::npos);
    warnings.push_back(result.err.substr(begin, result.err.find('\n', begin) - begin));
    take_mesh(in);
  }
  CHECK(warnings[0] == warnings[1]);
}

TEST_CASE("WhereMemoryCannotBeReachedFromOutsideTheMeshIsTheSame") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 6000);
  const std::string expected = mesh_of_one(in, job);
  // What several machines on Ethernet have.
  const ProgramResult result =
      run_by_ranks(3, job, in.path(), {"OMPI_MCA_btl=self,tcp", "OMPI_MCA_osc=pt2pt"});
  INFO(result.err);
  REQUIRE(result.status == 0);
  CHECK(take_mesh(in) == expected);
}

TEST_CASE("JobWithARankKilledResumesToTheSameMeshOfAnOrientedCloud", "[soak]") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  expect_same_bytes_after_kills(in, oriented_job(in, 15000));
}

TEST_CASE("JobWithARankKilledResumesToTheSameMeshOfRawScans") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  expect_same_bytes_after_kills(in, raw_job(in, 10000));
}

TEST_CASE("TilesetOfATeamThatIsKilledGoesOnByAnyNumberOfRanks", "[soak]") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory undisturbed, in;
  const std::string compression = GENERATE("none", "meshopt");
  const Job job = {"reconstruct",
                   "scan.ply",
                   "-o",
                   "mesh.ply",
                   "--tileset",
                   "levels",
                   "--report",
                   "report.json",
                   "--progress",
                   "none",
                   "--tileset-compression",
                   compression};
  for (const ScratchDirectory* where : {&undisturbed, &in})
    REQUIRE(run_in(*where, {"generate", "bumpy-torus", "--points", "200000", "-o", "scan.ply"})
                .status == 0);
  REQUIRE(run_in(undisturbed, job).status == 0);
  const std::filesystem::path stored = in / "mesh.work" / "tileset";
  for (const int ranks : {1, 3}) {
    INFO(ranks << " ranks go on");
    std::filesystem::remove_all(in / "levels");
    std::filesystem::remove(in / "report.json");
    {
      RunningProgram mpirun(by_ranks(2, job), mpi_setting(in.path()));
      const auto held = hold_ranks_when(mpirun, 2, [&] { return results_in(stored) >= 2; });
      REQUIRE_FALSE(held.empty());
      mpirun.send(SIGKILL);
      kill_all(held);
      mpirun.wait();
    }
    const std::size_t nodes = results_in(stored);
    REQUIRE(nodes >= 2);
    const ProgramResult resumed = run_by_ranks(ranks, job, in.path());
    INFO(resumed.err);
    REQUIRE(resumed.status == 0);
    const auto report = nlohmann::json::parse(file_text(in / "report.json"));
    for (const nlohmann::json& stage : report["stages"])
      if (stage["name"] == "tileset") CHECK(stage["chunks_reused"] == nodes);
    for (const auto& entry : std::filesystem::directory_iterator(undisturbed / "levels"))
      CHECK(
          (file_text(in / "levels" / entry.path().filename().string()) == file_text(entry.path())));
  }
}

TEST_CASE("EveryRankHasItsLogAndTheReportCountsThem") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 6000);
  const Job kept = job + Job{"--keep-work-dir", "--report", "report.json"};
  const ProgramResult result = run_by_ranks(3, kept, in.path());
  INFO(result.err);
  REQUIRE(result.status == 0);
  CHECK(count_of(file_text(in / "mesh.work" / "orbweave.log"), "rank 0 of 3") == 1);
  CHECK(count_of(file_text(in / "mesh.work" / "orbweave.rank1.log"), "rank 1 of 3") == 1);
  CHECK(count_of(file_text(in / "mesh.work" / "orbweave.rank2.log"), "rank 2 of 3") == 1);
  CHECK(nlohmann::json::parse(file_text(in / "report.json"))["ranks"] == 3);
}

TEST_CASE("TheReportCountsTheBytesAndTheCallsOfAllRanks") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 6000) + Job{"--report", "report.json"};
  const auto report_of = [&](int ranks) {
    const ProgramResult result = run_by_ranks(ranks, job, in.path());
    INFO(result.err);
    REQUIRE(result.status == 0);
    return nlohmann::json::parse(file_text(in / "report.json"));
  };
  const auto number = [](const nlohmann::json& report, const char* stage, const char* key) {
    for (const nlohmann::json& facts : report["stages"])
      if (facts["name"] == stage) return facts[key].get<double>();
    return -1.0;
  };
  const nlohmann::json one = report_of(1), three = report_of(3);
  const auto scan = static_cast<double>(std::filesystem::file_size(in / "cloud.ply"));
  const auto mesh = static_cast<double>(std::filesystem::file_size(in / "mesh.ply"));
  for (const nlohmann::json* report : {&one, &three}) {
    CHECK(number(*report, "count", "bytes_read") >= scan);
    CHECK(number(*report, "bin", "bytes_read") < 1.5 * scan);
    CHECK(number(*report, "export", "bytes_written") >= mesh);
    CHECK(number(*report, "export", "bytes_written") < 1.1 * mesh);
  }
  // What a stage reads of its chunks and writes is the same, whoever does it.
  for (const char* stage : {"sort", "reconstruct", "holes"}) {
    INFO(stage);
    CHECK(number(three, stage, "bytes_written") == number(one, stage, "bytes_written"));
  }
  // Bins of several ranks pass through the store.
  CHECK(number(three, "bin", "bytes_written") > 0.5 * scan);
  CHECK(number(three, "sort", "bytes_read") > 0.5 * scan);
  CHECK(one["traffic"]["counter_calls"] == 0);
  const double chunks = three["partition"]["chunks"];
  for (const char* stage : {"sort", "reconstruct"}) {
    INFO(stage);
    // Half of the work is dealt out without a call; every rank asks in vain once at most.
    CHECK(number(three, stage, "counter_calls") >= 1);
    CHECK(number(three, stage, "counter_calls") <= chunks / 2 + 3);
  }
}

TEST_CASE("NoCoreIsTwoRanksAndEveryRankHasAThread") {
  if (skipped_without_mpi()) return;
  const ScratchDirectory in;
  const Job job = oriented_job(in, 3000) + Job{"--keep-work-dir"};
  const int ranks = GENERATE(2, 3);
  const ProgramResult result = run_by_ranks(ranks, job, in.path());
  INFO(result.err);
  REQUIRE(result.status == 0);
  int threads = 0;
  for (int rank = 0; rank < ranks; ++rank) {
    const std::string name = rank == 0 ? "" : ".rank" + std::to_string(rank);
    const std::string log = file_text(in / "mesh.work" / ("orbweave" + name + ".log"));
    const std::string words =
        "rank " + std::to_string(rank) + " of " + std::to_string(ranks) + ": ";
    const std::size_t at = log.find(words);
    REQUIRE(at != std::string::npos);
    const int own = std::stoi(log.substr(at + words.size()));
    CHECK(own >= 1);
    threads += own;
  }
  CHECK(threads <= std::max(ranks, static_cast<int>(std::thread::hardware_concurrency())));
}
