// Scans that change between the runs of a job and while they are read.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "tests/engine/told_jobs.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/raw_scans.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::job_for;
using test::kept_job;
using test::painted_torus;
using test::RecordingProgress;
using test::run_told;
using test::ScratchDirectory;
using test::Told;
using test::without_work;

[[maybe_unused]] const bool in_memory = test::scratch_in_memory();

/// Bad input, as a job says it whose scan is changed at the beginning of a stage.
Error error_of_change(const Job& job, const std::string& stage,
                      const std::function<void(const fs::path&)>& change) {
  RecordingProgress progress;
  const StopToken stop;
  progress.at_stage = [&](const std::string& name) {
    if (name == stage) change(job.input.files.front());
  };
  try {
    run_job(job, {"test"}, progress, stop);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kBadInput);
    return error;
  }
  FAIL("nobody noticed");
  return Error(ErrorKind::kBadInput, "");
}

/// Another cloud in the place of a job's scan: of equal size, and with the time of the one before.
void replace_unseen(const Job& job, std::uint64_t seed) {
  const fs::path file = job.input.files.front();
  const auto time = fs::last_write_time(file);
  const auto bytes = fs::file_size(file);
  write_cloud(file, painted_torus(3000, 0.3, seed).cloud);
  REQUIRE(fs::file_size(file) == bytes);
  fs::last_write_time(file, time);
}

}  // namespace

TEST_CASE("AChangedScanIsNamedWithWhatItWasAndWhatItIs", "[costly]") {
  const ScratchDirectory scratch;
  const Job job = kept_job(scratch);
  const auto size = std::to_string(fs::file_size(job.input.files.front()));
  write_cloud(job.input.files.front(), painted_torus(2500, 0.3, 31).cloud);
  const Told told = run_told(job);
  CHECK(told.again().find(job.input.files.front() + " changed from " + size + " bytes of ") == 0);
  CHECK(told.again().find(": points, mesh and holes are computed again") != std::string::npos);
  CHECK((bytes_of(job.output.mesh) == without_work(job)));
}

TEST_CASE("AScanThatIsCutShortWhileItIsReadIsToldAsOneThatChanged") {
  const ScratchDirectory scratch;
  const Job job = job_for(scratch, painted_torus(3000, 0.3, 31));
  const Error error = error_of_change(
      job, "count", [](const fs::path& scan) { fs::resize_file(scan, fs::file_size(scan) / 2); });
  INFO(error.what());
  CHECK(error.parts().file == job.input.files.front());
  CHECK(error.problem() == "a scan changed while it was read");
  CHECK(error.parts().found.find("the file is shorter than its header says") != std::string::npos);
}

TEST_CASE("AScanThatChangesWhileItIsReadIsBadInputAndLeavesNothing") {
  for (const char* stage : {"count", "bin"}) {
    INFO(stage);
    const ScratchDirectory scratch;
    const Job job = job_for(scratch, painted_torus(3000, 0.3, 31));
    const Error error = error_of_change(job, stage, [](const fs::path& scan) {
      fs::last_write_time(scan, fs::last_write_time(scan) + std::chrono::hours(1));
    });
    CHECK(std::string(error.what()).find(job.input.files.front()) != std::string::npos);
    CHECK(std::string(error.what()).find("changed") != std::string::npos);
    CHECK_FALSE(fs::exists(job.output.mesh));
    CHECK_FALSE(fs::exists(job.run.work_dir));
  }
}

TEST_CASE("AScanThatIsReplacedByOneOfEqualSizeAndTimeIsNoticed", "[costly]") {
  const ScratchDirectory scratch;
  const Job job = kept_job(scratch);
  const std::string before = bytes_of(job.output.mesh);
  CHECK(run_told(job).again().empty());
  replace_unseen(job, 32);
  const Told told = run_told(job);
  CHECK(told.again().find(job.input.files.front() + " changed from ") == 0);
  CHECK(told.again().find(", sample ") != std::string::npos);
  CHECK(told.again().find(": points, mesh and holes are computed again") != std::string::npos);
  CHECK(told.stage("count") != nullptr);
  CHECK((bytes_of(job.output.mesh) != before));
  CHECK((bytes_of(job.output.mesh) == without_work(job)));
  const Told unchanged = run_told(job);
  CHECK(unchanged.again().empty());
  CHECK(unchanged.stage("count") == nullptr);
}

TEST_CASE("AMeshOfAScanThatWasReplacedSinceIsNotTakenForTheJobsEnd", "[costly]") {
  const ScratchDirectory scratch;
  Job job = kept_job(scratch);
  const std::string before = bytes_of(job.output.mesh);
  job.run.keep_work_dir = false;
  bool is_scan = true;
  SECTION("the scan") { replace_unseen(job, 33); }
  SECTION("the mesh itself") {
    is_scan = false;
    const auto time = fs::last_write_time(job.output.mesh);
    test::damage(job.output.mesh);
    fs::last_write_time(job.output.mesh, time);
  }
  const Told told = run_told(job);
  CHECK_FALSE(told.report.ended_before);
  CHECK((bytes_of(job.output.mesh) == before) == !is_scan);
}

TEST_CASE("AScanThatIsReplacedUnseenWhileItIsReadEndsTheRun") {
  const ScratchDirectory scratch;
  const Job job = job_for(scratch, painted_torus(3000, 0.3, 31));
  const Error error =
      error_of_change(job, "bin", [&](const fs::path&) { replace_unseen(job, 34); });
  const std::string message = error.what();
  CHECK(message.find("a scan changed while it was read; found ") != std::string::npos);
  CHECK(message.find(job.input.files.front() + " changed from ") != std::string::npos);
  CHECK_FALSE(fs::exists(job.output.mesh));
  CHECK_FALSE(fs::exists(job.run.work_dir));
}

TEST_CASE("TheReportSaysWhatOfTheInputIsTrusted") {
  const ScratchDirectory scratch;
  const Job job = job_for(scratch, test::scan_torus(scratch, 2500, 0.2, 0.3));
  const RunReport report = test::run(job);
  REQUIRE(report.trusted.size() == job.input.files.size() + 1);  // and the poses
  for (std::size_t i = 0; i < report.trusted.size(); ++i) {
    const TrustedFile& file = report.trusted[i];
    CHECK(file.file == (i < job.input.files.size() ? job.input.files[i] : job.input.poses));
    CHECK(file.bytes == fs::file_size(file.file));
    CHECK(file.bytes_hashed == std::min<std::uint64_t>(file.bytes, 262144));
    CHECK(file.modified.starts_with("20"));
  }
  CHECK(report_json(report).find("\"trusted\": [") != std::string::npos);
}

}  // namespace orbweave
