// What a run that was killed while it counted, binned or sorted leaves to the next one. The points
// are so wide that a few of them do not fit the buffers of the bins.
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <vector>

#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/points/own_share.h"
#include "io/clouds/open_point_source.h"
#include "io/clouds/point_source_list.h"
#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "io/points/point_source.h"
#include "partition/memory_plan.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/stored_damage.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::job_for;
using test::RecordingProgress;
using test::ScratchDirectory;

[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

constexpr std::size_t kPoints = 100'000;
constexpr std::size_t kFiles = 25;  // a batch of points each; buffers hold those of 17 or 18
constexpr int kThreads = 2;

test::NamedCloud wide_torus() {
  test::NamedCloud named = test::noisy_torus(kPoints, 0.1, 5);
  PointSchema& schema = named.cloud.schema;
  for (int i = 0; i < 52; ++i)
    schema.attributes.push_back({"a" + std::to_string(i), ScalarType::kFloat64});
  named.cloud.attributes.resize(kPoints * schema.attribute_bytes());
  for (std::size_t i = 0; i < named.cloud.attributes.size(); ++i)
    named.cloud.attributes[i] = static_cast<std::byte>(i * 37 / 8 & 0x3f);
  return named;
}

Job wide_job(const ScratchDirectory& scratch) {
  const test::NamedCloud named = wide_torus();
  std::vector<std::string> files;
  for (std::size_t file = 0; file < kFiles; ++file) {
    PointCloud part;
    part.schema = named.cloud.schema;
    const std::size_t first = file * kPoints / kFiles;
    for (std::size_t i = first; i < first + kPoints / kFiles; ++i) part.append(named.cloud, i);
    files.push_back((scratch / ("scan" + std::to_string(file) + ".ply")).string());
    write_cloud(files.back(), part);
  }
  Job job = job_for(scratch, named, files);
  job.reconstruct.ball_radii.resize(1);
  job.partition.chunk_points = 3000;
  job.partition.memory_bytes =
      least_budget_bytes(named.cloud.schema, kThreads) + (std::uint64_t{2} << 20);
  job.run.threads = kThreads;
  return job;
}

/// Remembers in which stages points were worked on that were not done before. Several threads tell
/// of points at once.
class CountingProgress final : public RecordingProgress {
 public:
  std::map<std::string, std::uint64_t> points;
  void add_points(std::uint64_t count) override {
    const std::scoped_lock lock(mutex_);
    points[stages.back()] += count;
  }

 private:
  std::mutex mutex_;
};

struct Told {
  std::vector<std::string> stages;
  std::map<std::string, std::uint64_t> points;  ///< by stage
  std::string lines;
  ErrorKind status = ErrorKind::kNone;
  std::string message;

  bool ran(const std::string& stage) const {
    return std::find(stages.begin(), stages.end(), stage) != stages.end();
  }
};

/// Runs the job until so many steps into a stage and stops it there.
Told run_until(const Job& job, const std::string& stage, int steps = 0,
               const std::function<void(const std::string&)>& at_stage = {}) {
  CountingProgress progress;
  StopToken stop;
  std::atomic<int> left{-1};
  progress.at_stage = [&](const std::string& name) {
    if (name == stage) left = steps;
    if (at_stage) at_stage(name);
  };
  progress.at_step = [&] {
    if (left >= 0 && left-- == 0) stop.request();
  };
  Told told;
  try {
    run_job(job, {"test"}, progress, stop);
  } catch (const Error& error) {
    told.status = error.kind();
    told.message = error.what();
  }
  told.stages = progress.stages;
  told.points = progress.points;
  for (const std::string& line : progress.lines) told.lines += line + "\n";
  return told;
}

/// The points as they are stored: the arrays of every file. (Files of two work directories differ
/// in whose they are.)
std::map<std::string, std::string> points_of(const Job& job) {
  const ChunkStore store(job.run.work_dir);
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(fs::path(job.run.work_dir) / "points")) {
    if (entry.path().extension() != ".h5") continue;
    const std::string name = entry.path().filename().string();
    const auto stored = store.open("points", static_cast<ChunkId>(std::stoul(name)));
    for (const char* array : {"positions", "block_bounds", "normals", "attributes"}) {
      const auto bytes = stored->read_all<char>(array);
      files[name].append(bytes.begin(), bytes.end());
    }
  }
  return files;
}

/// Of a run that nobody disturbed, up to the reconstruction.
const std::map<std::string, std::string>& expected_points(Job job) {
  static std::map<std::uint64_t, std::map<std::string, std::string>> known;
  std::map<std::string, std::string>& points = known[job.partition.chunk_points];
  if (!points.empty()) return points;
  job.run.work_dir += ".alone";
  const Told whole = run_until(job, "reconstruct");
  REQUIRE(whole.ran("count"));
  REQUIRE(whole.ran("bin"));
  points = points_of(job);
  REQUIRE(points.size() > 20);
  fs::remove_all(job.run.work_dir);
  return points;
}

fs::path cut_stage(const Job& job) { return fs::path(job.run.work_dir) / "points_cut"; }

/// The next run goes on to the reconstruction, with the points that it should have.
Told check_resumes(const Job& job, const std::map<std::string, std::string>& expected) {
  Told told = run_until(job, "reconstruct");
  INFO(told.message);
  REQUIRE(told.ran("reconstruct"));
  CHECK((points_of(job) == expected));
  CHECK_FALSE(fs::exists(cut_stage(job)));
  return told;
}

void flip_a_byte_of_every_bin(const fs::path& bins) {
  std::fstream file(bins, std::ios::in | std::ios::out | std::ios::binary);
  const auto size = static_cast<std::streamoff>(fs::file_size(bins));
  for (std::streamoff at = 5000; at < size; at += 50'000) {
    file.seekg(at);
    const int byte = file.get();
    file.seekp(at);
    file.put(static_cast<char>(byte ^ 1));
  }
}

}  // namespace

TEST_CASE("KilledWhileItSortsARunCountsAndBinsNothingAgain", "[soak]") {
  const ScratchDirectory scratch;
  Job job = wide_job(scratch);
  const auto& expected = expected_points(job);
  const Told killed = run_until(job, "sort", 8);
  REQUIRE(killed.status == ErrorKind::kInterrupted);
  REQUIRE(fs::exists(cut_stage(job) / "bins.0"));
  REQUIRE(test::results_in(fs::path(job.run.work_dir) / "points") > 0);
  SECTION("with the same options") {}
  SECTION("with more memory than the bins take") {
    job.partition.memory_bytes = std::uint64_t{2} << 30;
  }
  SECTION("with less memory") { job.partition.memory_bytes -= std::uint64_t{1} << 20; }
  SECTION("with one thread") { job.run.threads = 1; }
  const Told told = check_resumes(job, expected);
  CHECK_FALSE(told.ran("count"));
  CHECK_FALSE(told.ran("bin"));
  CHECK_FALSE(told.ran("measure"));
  CHECK(told.points.at("sort") > 0);
  CHECK(told.points.at("sort") < kPoints);
  CHECK(told.lines.find("resuming: the points are counted and binned already") !=
        std::string::npos);
}

TEST_CASE("KilledWhileItMeasuresARunBinsNothingAgain", "[costly]") {
  const ScratchDirectory scratch;
  const Job job = wide_job(scratch);
  const auto& expected = expected_points(job);
  REQUIRE(run_until(job, "measure").status == ErrorKind::kInterrupted);
  fs::remove(cut_stage(job) / "measured.json.xxh3");
  const Told told = check_resumes(job, expected);
  CHECK_FALSE(told.ran("count"));
  CHECK_FALSE(told.ran("bin"));
  CHECK(told.ran("measure"));
}

TEST_CASE("KilledWhileItBinsARunCountsNothingAgainAndBinsTheRest", "[soak]") {
  const ScratchDirectory scratch;
  const Job job = wide_job(scratch);
  const auto& expected = expected_points(job);
  // The beginning, what was done before, twenty batches of points; few are read ahead.
  REQUIRE(run_until(job, "bin", 21).status == ErrorKind::kInterrupted);
  SECTION("as it was killed") {
    const Told told = check_resumes(job, expected);
    CHECK_FALSE(told.ran("count"));
    CHECK(told.points.at("bin") <= kPoints / 2);
  }
  SECTION("and the last bytes were lost") {
    const fs::path bins = cut_stage(job) / "bins.0";
    fs::resize_file(bins, fs::file_size(bins) - 1);
    const Told told = check_resumes(job, expected);
    CHECK_FALSE(told.ran("count"));
    CHECK(told.points.at("bin") == kPoints);
  }
  SECTION("and the last bytes were lost, and it was killed again when others had come") {
    const fs::path bins = cut_stage(job) / "bins.0";
    const auto bytes = fs::file_size(bins);
    fs::resize_file(bins, bytes / 2);
    REQUIRE(run_until(job, "bin", 2).status == ErrorKind::kInterrupted);
    fs::resize_file(bins, bytes);
    const Told told = check_resumes(job, expected);
    CHECK_FALSE(told.ran("count"));
    CHECK(told.points.at("bin") == kPoints);
  }
}

TEST_CASE("KilledWhenItHasCountedARunCountsNothingAgain", "[soak]") {
  const ScratchDirectory scratch;
  Job job = wide_job(scratch);
  const auto& expected = expected_points(job);
  REQUIRE(run_until(job, "bin").status == ErrorKind::kInterrupted);
  const bool changed = GENERATE(false, true);
  if (changed) {
    const fs::path scan = job.input.files.front();
    fs::last_write_time(scan, fs::last_write_time(scan) + std::chrono::hours(1));
  }
  const Told told = check_resumes(job, expected);
  CHECK(told.ran("count") == changed);
  CHECK(told.ran("bin"));
}

TEST_CASE("BinsThatAreDamagedOrGoneAreMadeAgainAndItSaysSo", "[soak]") {
  const ScratchDirectory scratch;
  Job job = wide_job(scratch);
  const auto& expected = expected_points(job);
  REQUIRE(run_until(job, "sort", 8).status == ErrorKind::kInterrupted);
  const fs::path bins = cut_stage(job) / "bins.0";
  bool counts = false;
  std::string says = "points that were binned are damaged or gone";
  SECTION("changed bytes") {
    flip_a_byte_of_every_bin(bins);
    counts = true;  // noticed in the middle of the job, which begins anew
    says = bins.string();
  }
  SECTION("the file is gone") { fs::remove(bins); }
  SECTION("its end is gone") { fs::resize_file(bins, fs::file_size(bins) / 2); }
  SECTION("what says where everything lies is damaged") {
    for (const auto& entry : fs::directory_iterator(cut_stage(job)))
      if (entry.path().extension() == ".h5") fs::resize_file(entry.path(), 100);
    counts = true;
  }
  const Told told = check_resumes(job, expected);
  CHECK(told.ran("count") == counts);
  CHECK(told.ran("bin"));
  CHECK(told.points.at("sort") < kPoints);
  CHECK(told.lines.find(says) != std::string::npos);
}

TEST_CASE("ASortedChunkThatIsDamagedWhenItsBinIsGoneIsNotLookedForInTheBins", "[soak]") {
  const ScratchDirectory scratch;
  const Job job = wide_job(scratch);
  const auto& expected = expected_points(job);
  REQUIRE(run_until(job, "sort", 8).status == ErrorKind::kInterrupted);
  std::string damaged;
  for (const auto& [name, content] : points_of(job)) damaged = name;
  const fs::path result = fs::path(job.run.work_dir) / "points" / damaged;
  fs::resize_file(result, 100);
  const Told told = check_resumes(job, expected);
  CHECK(told.ran("count"));
  CHECK(told.lines.find(result.string()) != std::string::npos);
  CHECK(told.lines.find("bins.0") == std::string::npos);
}

TEST_CASE("WhateverTakesThePlaceOfStoredBinsAndTheirLogThePointsAreTheSame", "[soak]") {
  const ScratchDirectory scratch;
  const Job job = wide_job(scratch);
  const auto& expected = expected_points(job);
  const test::StoredDirectories directories = {job.run.work_dir, scratch / "older",
                                               scratch / "other"};
  const auto keep = [](const fs::path& from, const fs::path& to) {
    fs::remove_all(to);
    fs::copy(from, to, fs::copy_options::recursive);
  };
  std::mt19937_64 random(23);
  const auto stop_in_sort = [](const Job& stopped) {
    REQUIRE(run_until(stopped, "sort", 8).status == ErrorKind::kInterrupted);
  };
  Job before = job;
  before.partition.chunk_points += 500;
  stop_in_sort(before);
  keep(job.run.work_dir, directories.older);
  stop_in_sort(job);
  Job other = job;
  other.run.work_dir = directories.other.string();
  stop_in_sort(other);
  keep(job.run.work_dir, scratch / "whole");
  const std::vector<fs::path> files = test::stored_files(scratch / "whole");
  int done = 0;
  for (std::size_t trial = 0; done < 12; ++trial) {
    const auto damage = test::kStoredDamages[trial % (test::kStoredDamages.size() - 1)];
    std::vector<fs::path> cut;
    for (const fs::path& file : files)
      if (file.parent_path() == "points_cut" || trial % 3 == 0) cut.push_back(file);
    const fs::path& file = cut[random() % cut.size()];
    keep(scratch / "whole", job.run.work_dir);
    if (!test::apply(damage, file, directories, random)) continue;
    INFO(test::name_of(damage) << " " << file);
    check_resumes(job, expected);
    ++done;
  }
}

TEST_CASE("BinsOfOtherScansAreNotUsed", "[soak]") {
  const ScratchDirectory scratch;
  Job job = wide_job(scratch);
  REQUIRE(run_until(job, "sort", 8).status == ErrorKind::kInterrupted);
  SECTION("another scan") {
    const fs::path scan = job.input.files.front();
    fs::last_write_time(scan, fs::last_write_time(scan) + std::chrono::hours(1));
  }
  SECTION("another chunk size") { job.partition.chunk_points = 4000; }
  SECTION("a fresh start") { job.run.fresh = true; }
  const Told told = check_resumes(job, expected_points(job));
  CHECK(told.ran("count"));
  CHECK(told.ran("bin"));
}

TEST_CASE("ADiskThatIsFullWhileBinsAreWrittenEndsInStatus4AndTheCountIsKept", "[soak]") {
  const ScratchDirectory scratch;
  const Job job = wide_job(scratch);
  const auto& expected = expected_points(job);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, SIG_IGN);
  const std::uint64_t limit = GENERATE(1'000'000u, 38'000'000u);
  const Told full = run_until(job, "reconstruct", 0, [&](const std::string& name) {
    const rlimit low{limit, before.rlim_max};
    if (name == "bin") setrlimit(RLIMIT_FSIZE, &low);
  });
  setrlimit(RLIMIT_FSIZE, &before);
  INFO(full.message);
  CHECK(full.status == ErrorKind::kResource);
  CHECK(full.message.find("bins.0") != std::string::npos);
  CHECK(full.message.find("File too large") != std::string::npos);
  const Told told = check_resumes(job, expected);
  CHECK_FALSE(told.ran("count"));
  CHECK(told.ran("bin"));
}

TEST_CASE("AShareThatWasPartlyReadGoesOnWithTheNextPoint") {
  const ScratchDirectory scratch;
  const PointCloud cloud = test::painted_torus(1000, 0.1, 3).cloud;  // of 993
  const std::string name = GENERATE("cloud.ply", "cloud.ply.gz", "cloud.xyz");
  const fs::path file = scratch / name;
  write_cloud(file.string(), cloud);
  const bool rows_are_points = GENERATE(true, false);
  const std::uint64_t before = GENERATE(0u, 1u, 317u, 993u);
  const std::size_t capacity = GENERATE(100u, 5000u);
  INFO(name << ", " << before << " points before, " << capacity << " at a time");
  const PointCloud all = read_all(*open_point_source(file));
  REQUIRE(all.size() == cloud.size());
  const auto source = own_share(open_point_source(file), Communicator(), before, rows_are_points);
  std::vector<Vec3> rest;
  for (PointCloud batch; source->read(batch, capacity);) {
    CHECK(batch.normals.size() == batch.size());
    rest.insert(rest.end(), batch.positions.begin(), batch.positions.end());
  }
  CHECK((rest == std::vector<Vec3>(all.positions.begin() + static_cast<std::ptrdiff_t>(before),
                                   all.positions.end())));
}

TEST_CASE("AShareOfAListGoesOnWithTheNextPointWhereFilesAreReadAsAWholeOnly") {
  const ScratchDirectory scratch;
  const PointCloud cloud = test::painted_torus(1000, 0.1, 3).cloud;  // of 993
  const std::vector<std::string> names =
      GENERATE(values<std::vector<std::string>>({{"one.ply", "two.ply"},
                                                 {"one.ply.gz"},
                                                 {"one.ply.gz", "two.ply"},
                                                 {"one.ply", "two.ply.gz"},
                                                 {"one.xyz", "two.ply"}}));
  std::vector<fs::path> files;
  for (const std::string& name : names) {
    files.push_back(scratch / name);
    write_cloud(files.back().string(), cloud);
  }
  const std::uint64_t before = GENERATE(1u, 317u, 993u, 1310u);
  INFO(names.front() << ", " << names.size() << " files, " << before << " points before");
  const std::vector<Vec3> all = read_all(*open_point_sources(files)).positions;
  REQUIRE(all.size() == cloud.size() * files.size());
  const auto source = own_share(open_point_sources(files), Communicator(), before, true);
  CHECK((read_all(*source).positions ==
         std::vector<Vec3>(
             all.begin() + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(before, all.size())),
             all.end())));
}

TEST_CASE("BinsThatFitInMemoryAreNotWritten", "[costly]") {
  const ScratchDirectory scratch;
  Job job = wide_job(scratch);
  job.partition.memory_bytes = std::uint64_t{2} << 30;
  REQUIRE(run_until(job, "sort", 8).status == ErrorKind::kInterrupted);
  CHECK_FALSE(fs::exists(cut_stage(job)));
}

}  // namespace orbweave
