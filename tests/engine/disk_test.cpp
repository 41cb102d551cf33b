// Disks that are full, read-only, damaged or gone, in every stage of a job: what the user is told,
// what is kept, and that the same command then ends with the same bytes.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <iostream>
#include <optional>
#include <set>

#include "engine/pipeline/budget/disk_plan.h"
#include "engine/planning/plan_job.h"
#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "io/system/path_roles.h"
#include "tests/support/jobs.h"
#include "tests/support/raw_scans.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;
namespace fs = std::filesystem;

namespace {

[[maybe_unused]] const bool in_memory = scratch_in_memory();

/// Files of this process cannot grow beyond a size: what is written there fails as on a full disk,
/// wherever tests run.
class FullDisk {
 public:
  explicit FullDisk(std::uint64_t bytes) {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit low{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &low);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

/// Root may write everywhere: until the object dies, it is somebody else.
class NotRoot {
 public:
  NotRoot() : root_(geteuid() == 0) {
    if (root_ && !become_nobody()) FAIL("root cannot become somebody else");
  }
  /// True, after saying so, where there is nobody else: in a container that has root alone.
  static bool skipped() {
    const pid_t child = fork();
    if (child == 0) _exit(geteuid() != 0 || become_nobody() ? 0 : 1);
    int status = 0;
    waitpid(child, &status, 0);
    if (status != 0) std::cout << "SKIPPED: there is no user but root\n";
    return status != 0;
  }
  ~NotRoot() {
    if (root_ && setresuid(0, 0, 0) != 0) std::terminate();
  }
  NotRoot(const NotRoot&) = delete;
  NotRoot& operator=(const NotRoot&) = delete;

 private:
  static bool become_nobody() {
    constexpr uid_t kNobody = 65534;
    return setresuid(kNobody, kNobody, 0) == 0;
  }
  bool root_;
};

struct Outcome {
  std::optional<ErrorKind> status;  ///< nothing: it ended well
  std::string message;
  std::vector<std::string> stages;
  std::vector<std::string> lines;
  RunReport report;
  bool ran(const std::string& stage) const {
    return std::find(stages.begin(), stages.end(), stage) != stages.end();
  }
};

Outcome attempt(const Job& job, const std::function<void(const std::string&)>& at_stage = {}) {
  RecordingProgress progress;
  progress.at_stage = at_stage;
  const StopToken stop;
  Outcome outcome;
  try {
    outcome.report = run_job(job, {"test"}, progress, stop);
  } catch (const Error& error) {
    outcome.status = error.kind();
    outcome.message = error.what();
  }
  outcome.stages = progress.stages;
  outcome.lines = progress.lines;
  return outcome;
}

/// A job of every stage on points with normals, holes and report included.
Job oriented_job(const ScratchDirectory& scratch) {
  Job job = job_for(scratch, painted_torus(1000, 0.3, 3));
  job.partition.chunk_points = 400;
  job.run.threads = 2;
  job.output.report = (scratch / "report.json").string();
  return job;
}

/// A job of every pass over raw points.
Job raw_job(const ScratchDirectory& scratch) {
  NamedCloud named = painted_torus(800, 0.1, 11);
  named.cloud.normals.clear();
  named.cloud.schema.has_normals = false;
  Job job = job_for(scratch, named);
  job.reconstruct.ball_radii.resize(1);
  job.partition.chunk_points = 500;
  job.run.threads = 2;
  job.normals.orientation = Orientation::kPropagate;
  job.cleaning.outlier_sigma = 4.0;
  job.cleaning.merge_tolerance = 0.05 * named.ball_radius;
  job.cleaning.smooth_radius = 2.0 * named.ball_radius;
  job.cleaning.thin_to_spacing = 0.3 * named.ball_radius;
  return job;
}

struct Expected {
  std::string bytes;
  std::vector<std::string> stages;
};
Expected expected_of(const Job& job) {
  const Outcome whole = attempt(job);
  REQUIRE_FALSE(whole.status);
  Expected expected{bytes_of(job.output.mesh), whole.stages};
  for (const std::string& output : {job.output.mesh, job.output.picture, job.output.report})
    fs::remove(output);
  return expected;
}

void check_resumes(const Job& job, const Expected& expected) {
  const Outcome again = attempt(job);
  INFO("the same command again: " << again.message);
  REQUIRE_FALSE(again.status);
  REQUIRE((bytes_of(job.output.mesh) == expected.bytes));
  CHECK_FALSE(fs::exists(job.run.work_dir));
  for (const std::string& output : {job.output.mesh, job.output.picture, job.output.report})
    fs::remove(output);
}

/// Whether any file in a directory is something that was not finished.
bool has_leftovers(const fs::path& directory) {
  for (const fs::directory_entry& entry : fs::directory_iterator(directory))
    if (entry.path().extension() == ".part") return true;
  return false;
}

using Stages = std::vector<std::string>;

/// Without `only`, in every stage that the job has.
void check_full_disk(const Job& job, std::uint64_t limit, const Stages& only = {}) {
  const Expected expected = expected_of(job);
  for (const std::string& stage : only.empty() ? expected.stages : only) {
    INFO("full from stage " << stage << ", limit " << limit);
    std::optional<FullDisk> full;
    const Outcome outcome = attempt(job, [&](const std::string& name) {
      if (name == stage && !full) full.emplace(limit);
    });
    full.reset();
    INFO(outcome.message);
    REQUIRE(outcome.status == ErrorKind::kResource);
    CHECK_THAT(outcome.message, Contains(fs::path(job.run.work_dir).parent_path().string()));
    CHECK_THAT(outcome.message, Contains("File too large"));
    CHECK(fs::exists(fs::path(job.run.work_dir) / "orbweave-store.json"));
    CHECK_FALSE(has_leftovers(fs::path(job.output.mesh).parent_path()));
    check_resumes(job, expected);
  }
}

/// Something happens when a stage begins; the job ends in status 4 and names `named`, or did not
/// notice; then the same command ends with the same bytes.
void check_mishap(const Job& job, const std::function<void()>& mishap,
                  const std::function<void()>& repair, const std::string& named,
                  const std::set<std::string>& notices, const Stages& only = {}) {
  const Expected expected = expected_of(job);
  for (const std::string& stage : only.empty() ? expected.stages : only) {
    INFO("from stage " << stage);
    bool happened = false;
    const Outcome outcome = attempt(job, [&](const std::string& name) {
      if (name == stage && !std::exchange(happened, true)) mishap();
    });
    repair();
    INFO(outcome.message);
    if (outcome.status || notices.contains(stage)) {
      REQUIRE(outcome.status == ErrorKind::kResource);
      CHECK_THAT(outcome.message, Contains(named));
    }
    check_resumes(job, expected);
  }
}

std::vector<fs::path> stored_results(const fs::path& work_dir) {
  std::vector<fs::path> results;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(work_dir))
    if (entry.path().extension() == ".h5") results.push_back(entry.path());
  std::sort(results.begin(), results.end());
  return results;
}

/// Flips a bit in one result of every stage that is there, and that was not damaged before.
void damage_every_stage(const fs::path& work_dir, std::set<fs::path>& damaged) {
  for (const fs::path& result : stored_results(work_dir)) {
    if (fs::file_size(result) < 4096 || !damaged.insert(result.parent_path()).second) continue;
    damage(result);
  }
}

void check_damage(const Job& job, const Stages& only = {}) {
  const Expected expected = expected_of(job);
  for (const std::string& stage : only.empty() ? expected.stages : only) {
    INFO("damaged before stage " << stage);
    std::set<fs::path> damaged;
    const Outcome outcome = attempt(job, [&](const std::string& name) {
      if (name == stage && damaged.empty()) damage_every_stage(job.run.work_dir, damaged);
    });
    INFO(outcome.message);
    REQUIRE_FALSE(outcome.status);
    REQUIRE((bytes_of(job.output.mesh) == expected.bytes));
    for (const std::string& output : {job.output.mesh, job.output.picture, job.output.report})
      fs::remove(output);
  }
}

}  // namespace

TEST_CASE("AFolderThatMayNotBeWrittenAsksForOtherPermissions") {
  if (NotRoot::skipped()) return;
  const ScratchDirectory scratch;
  fs::create_directory(scratch / "ro");
  fs::permissions(scratch / "ro", fs::perms{0555});
  fs::permissions(scratch.path(), fs::perms{0755});  // anybody may enter
  const std::vector<PathRole> paths = {
      {"the mesh", scratch / "ro" / "m.ply", PathUse::kWrittenFile}};
  const NotRoot user;
  CHECK_THROWS_WITH(check_paths(paths), Contains("ro: Permission denied") &&
                                            Contains("Change the permissions there or choose") &&
                                            !Contains("Create"));
}

TEST_CASE("AFullDiskInAnyStageEndsInStatus4AndTheSameCommandResumes", "[costly]") {
  ScratchDirectory scratch;
  Job job = oriented_job(scratch);
  check_full_disk(job, 30'000);
  job.output.picture = (scratch / "picture.png").string();
  check_full_disk(job, 30'000, {"picture"});
}

TEST_CASE("AFullDiskInAnyPassOverRawPointsEndsInStatus4AndTheSameCommandResumes", "[slow]") {
  ScratchDirectory scratch;
  check_full_disk(raw_job(scratch), 1);
}

TEST_CASE("WhatWasDoneBeforeTheDiskWasFullIsNotDoneAgain") {
  ScratchDirectory scratch;
  const Job job = oriented_job(scratch);
  std::optional<FullDisk> full;
  attempt(job, [&](const std::string& name) {
    if (name == "export") full.emplace(1);
  });
  full.reset();
  CHECK_FALSE(fs::exists(job.output.mesh));
  const Outcome again = attempt(job);
  REQUIRE_FALSE(again.status);
  CHECK_FALSE(again.ran("bin"));
  CHECK_FALSE(again.ran("sort"));
  for (const StageFacts& stage : again.report.stages)
    if (stage.name == "reconstruct") CHECK(stage.chunks_reused == stage.chunks);
}

TEST_CASE("AWorkDirectoryThatIsRemovedUnderTheJobEndsInStatus4", "[costly]") {
  ScratchDirectory scratch;
  const Job job = oriented_job(scratch);
  check_mishap(
      job, [&] { fs::remove_all(job.run.work_dir); }, [] {}, job.run.work_dir,
      {"sort", "stitch", "export"});
}

TEST_CASE("AWorkDirectoryThatIsRemovedUnderAnyPassOverRawPointsEndsInStatus4", "[slow]") {
  ScratchDirectory scratch;
  const Job job = raw_job(scratch);
  check_mishap(
      job, [&] { fs::remove_all(job.run.work_dir); }, [] {}, job.run.work_dir,
      {"raw_outliers", "raw_normals", "raw_smooth_1", "raw_thinned", "raw_patches", "sort"});
}

TEST_CASE("AnOutputDirectoryThatVanishesEndsInStatus4AndKeepsTheWork", "[slow]") {
  ScratchDirectory scratch;
  Job job = oriented_job(scratch);
  const fs::path out = scratch / "out";
  fs::create_directory(out);
  job.output.mesh = (out / "mesh.ply").string();
  job.output.report = (out / "mesh.json").string();
  const auto vanish = [&] { fs::remove_all(out); };
  const auto repair = [&] { fs::create_directory(out); };
  check_mishap(job, vanish, repair, out.string(),
               {"count", "sort", "reconstruct", "holes", "export"});
  job.output.picture = (out / "mesh.png").string();
  check_mishap(job, vanish, repair, out.string(), {"picture"}, {"picture"});
}

TEST_CASE("ReadOnlyDirectoriesEndInStatus4AndSaySo") {
  if (NotRoot::skipped()) return;
  ScratchDirectory scratch;
  fs::permissions(scratch.path(), fs::perms(0755));
  Job job = oriented_job(scratch);
  const fs::path out = scratch / "out";
  fs::create_directory(out);
  job.output.mesh = (out / "mesh.ply").string();
  job.output.picture.clear();
  job.output.report.clear();
  job.run.work_dir = (out / "work").string();
  fs::permissions(out, fs::perms(0555));
  {
    const NotRoot somebody;
    const Outcome outcome = attempt(job);
    CHECK(outcome.status == ErrorKind::kResource);
    CHECK_THAT(outcome.message, Contains(job.output.mesh) && Contains("Permission denied"));
  }
  const fs::path elsewhere = scratch / "elsewhere";
  fs::create_directory(elsewhere);
  fs::permissions(elsewhere, fs::perms(0777));
  job.output.mesh = (elsewhere / "mesh.ply").string();
  {
    const NotRoot somebody;
    const Outcome outcome = attempt(job);
    CHECK(outcome.status == ErrorKind::kResource);
    CHECK_THAT(outcome.message, Contains(job.run.work_dir) && Contains("ermission denied"));
  }
  job.run.work_dir = (elsewhere / "work").string();
  {
    const NotRoot somebody;
    const Expected expected = expected_of(job);
    for (const char* stage : {"sort", "reconstruct", "holes"}) {
      INFO("read-only from stage " << stage);
      const fs::path work = job.run.work_dir;
      const Outcome outcome = attempt(job, [&](const std::string& name) {
        if (name != stage) return;
        for (const fs::directory_entry& entry : fs::directory_iterator(work))
          if (entry.is_directory()) fs::permissions(entry.path(), fs::perms(0555));
        fs::permissions(work, fs::perms(0555));
      });
      fs::permissions(work, fs::perms(0755));
      for (const fs::directory_entry& entry : fs::directory_iterator(work))
        if (entry.is_directory()) fs::permissions(entry.path(), fs::perms(0755));
      INFO(outcome.message);
      REQUIRE(outcome.status == ErrorKind::kResource);
      CHECK_THAT(outcome.message, Contains(job.run.work_dir) && Contains("ermission denied"));
      check_resumes(job, expected);
    }
  }
}

TEST_CASE("DamagedResultsOfAnyStageAreNoticedAndComputedAgain", "[costly]") {
  ScratchDirectory scratch;
  check_damage(oriented_job(scratch));
}

TEST_CASE("DamagedResultsOfAnyPassOverRawPointsAreNoticedAndComputedAgain", "[slow]") {
  ScratchDirectory scratch;
  check_damage(raw_job(scratch));
}

TEST_CASE("CompressedResultsGiveTheSameBytesAlsoWhereSomeAreNot", "[costly]") {
  ScratchDirectory scratch;
  // Arrays of fewer than 1024 rows are not packed.
  Job job = job_for(scratch, painted_torus(4000, 0.1, 3));
  job.reconstruct.ball_radii.resize(1);
  job.partition.chunk_points = 3000;
  const Expected expected = expected_of(job);
  for (const bool first : {true, false}) {
    job.run.compress = first;
    std::optional<FullDisk> full;
    const Outcome outcome = attempt(job, [&](const std::string& name) {
      if (name == "export") full.emplace(1);
    });
    full.reset();
    REQUIRE(outcome.status == ErrorKind::kResource);
    job.run.compress = !first;
    const Outcome again = attempt(job);
    INFO(again.message);
    REQUIRE_FALSE(again.status);
    CHECK_FALSE(again.ran("sort"));
    CHECK((bytes_of(job.output.mesh) == expected.bytes));
    fs::remove(job.output.mesh);
  }
  job.run.compress = true;
  check_damage(job, {"reconstruct", "stitch", "export"});
}

TEST_CASE("PredictedRoomIsNotBelowWhatIsUsedAndAtMostAQuarterAbove", "[costly]") {
  ScratchDirectory scratch;
  NamedCloud named = noisy_torus(30'000, 0.0, 3);
  const bool raw = GENERATE(false, true);
  if (raw) {
    named.cloud.normals.clear();
    named.cloud.schema.has_normals = false;
  }
  Job job = job_for(scratch, named);
  job.reconstruct.ball_radii = {named.ball_radius};
  job.partition.chunk_points = GENERATE(5'000u, 30'000u);
  job.run.compress = !raw && job.partition.chunk_points > 5'000 && GENERATE(false, true);
  const JobPlan plan = [&] {
    RecordingProgress progress;
    return plan_job(job, progress, StopToken());
  }();
  const RunReport report = run(job);
  INFO((raw ? "raw" : "oriented") << ", chunks of " << job.partition.chunk_points
                                  << (job.run.compress ? ", compressed" : ""));
  CHECK(plan.disk_bytes == report.predicted.disk_bytes);
  CHECK(report.predicted.disk_bytes >= report.measured.disk_bytes);
  if (!job.run.compress) {
    CHECK(static_cast<double>(report.predicted.disk_bytes) <=
          1.25 * static_cast<double>(report.measured.disk_bytes));
  }
  CHECK(report.measured.disk_bytes > fs::file_size(job.output.mesh));
}

TEST_CASE("TooLittleRoomIsSaidBeforeTheWork") {
  ScratchDirectory scratch;
  OutputOptions output;
  output.mesh = (scratch / "mesh.ply").string();
  const std::uint64_t huge = std::uint64_t{1} << 60;
  const DiskPlan plan{
      .cleaning_bytes = 0, .work_bytes = huge, .output_bytes = 1, .most_bytes = huge};
  try {
    require_room(scratch / "not/yet/there", output, plan, 0);
    FAIL("an exbibyte is free");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kResource);
    CHECK_THAT(error.what(), Contains((scratch / "not/yet/there").string()) && Contains("free") &&
                                 Contains("at least") && Contains("--work-dir"));
  }
  // What the directory holds already is part of what was predicted.
  CHECK_NOTHROW(require_room(scratch.path(), output, plan, huge));
  DiskPlan with_levels{.work_bytes = 1, .output_bytes = 1, .most_bytes = 2};
  CHECK_NOTHROW(require_room(scratch.path(), output, with_levels, 0));
  with_levels.tileset_bytes = huge;
  output.tileset = (scratch / "levels").string();
  CHECK_THROWS_WITH(
      require_room(scratch.path(), output, with_levels, 0),
      Contains("the work directory and the mesh and the tileset") && Contains("at least"));
}

TEST_CASE("TilesOnAMapGridArePartOfTheForecastOfTheDisk") {
  const ScratchDirectory scratch;
  Job job = test::job_for(scratch, test::noisy_torus(20'000, 0.0, 7));
  job.output.tiles = true;
  const auto report_of = [&] {
    const RunReport report = test::run(job);
    CHECK(report.predicted.disk_bytes >= report.measured.disk_bytes);
    return report;
  };
  const RunReport by_chunk = report_of();
  job.output.tile_size = 0.5;
  const RunReport by_cell = report_of();
  // Positions and 40,000 sorted triangles lie beside the tiles.
  constexpr std::uint64_t kOnTheWay = 20'000 * 24 + 40'000 * 40;
  CHECK(by_cell.predicted.disk_bytes >= by_chunk.predicted.disk_bytes + kOnTheWay);
  CHECK(by_cell.measured.disk_bytes >= by_chunk.measured.disk_bytes + kOnTheWay);
}

TEST_CASE("ATilesetAndASimplifiedMeshArePartOfTheForecastOfTheDisk") {
  const ScratchDirectory scratch;
  Job job = test::job_for(scratch, test::noisy_torus(2000, 0.0, 7));
  const auto report_of = [&] {
    const RunReport report = test::run(job);
    CHECK(report.predicted.disk_bytes >= report.measured.disk_bytes);
    return report;
  };
  const RunReport bare = report_of();
  job.output.tileset = (scratch / "levels").string();
  job.output.simplify = SimplifyTarget{SimplifyTarget::Kind::kRatio, 0.5};
  const RunReport full = report_of();
  CHECK(full.predicted.disk_bytes > bare.predicted.disk_bytes + 100 * 2000);
  CHECK(full.measured.disk_bytes > bare.measured.disk_bytes);
  std::uint64_t tiles = 0;
  for (const auto& entry : fs::directory_iterator(scratch / "levels"))
    tiles += fs::file_size(entry.path());
  CHECK(full.predicted.disk_bytes > bare.predicted.disk_bytes + tiles);
}
