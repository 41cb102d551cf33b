// What a work directory tells about the run that uses or used it.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <ctime>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>

#include "engine/pipeline/orientation_stage.h"
#include "engine/pipeline/partition_stage.h"
#include "engine/pipeline/patch_batch.h"
#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/prepare_stage.h"
#include "engine/pipeline/reconstruct_stage.h"
#include "io/chunk_points.h"
#include "io/error.h"
#include "io/store_lock.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// Results of a stage: whole ones, and those that are written and have no name yet.
struct Results {
  std::uint64_t committed = 0;
  std::uint64_t in_flight = 0;
};

Results results_of(const fs::path& stage) {
  Results results;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(stage, ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(".h5.part")) ++results.in_flight;
    if (name.ends_with(".h5") && !name.starts_with(".")) ++results.committed;
  }
  return results;
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Whether some process holds the lock.
bool is_locked(const fs::path& lock) {
  const int descriptor = open(lock.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool held = flock(descriptor, LOCK_SH | LOCK_NB) != 0;
  close(descriptor);
  return held;
}

std::string iso_time(fs::file_time_type time) {
  const auto system = std::chrono::file_clock::to_sys(time);
  const std::time_t seconds = std::chrono::system_clock::to_time_t(
      std::chrono::time_point_cast<std::chrono::seconds>(system));
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

std::string last_touched(const fs::path& directory) {
  fs::file_time_type latest = fs::last_write_time(directory);
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(directory, ignored)) {
    const auto time = entry.last_write_time(ignored);
    if (!ignored) latest = std::max(latest, time);
  }
  return iso_time(latest);
}

/// Chunks of a partition; 0: not cut yet.
std::uint64_t chunks_of(const fs::path& document) {
  const std::string text = text_of(document);
  if (text.empty()) return 0;
  try {
    return partition_from_json(text).octree.chunks().size();
  } catch (const std::exception&) {
    return 0;  // damaged, or of another version: no partition
  }
}

/// Batches of holes; 0: not known yet.
std::uint64_t batches_of(const fs::path& document) {
  const auto json = nlohmann::json::parse(text_of(document), nullptr, false);
  if (!json.is_object() || !json.contains("batches")) return 0;
  return json["batches"].is_number_unsigned() ? json["batches"].get<std::uint64_t>() : 0;
}

/// What the log says of the last run.
struct LoggedSteps {
  std::string last;                             ///< begun last
  std::map<std::string, std::uint64_t> totals;  ///< of the steps that told
};

LoggedSteps logged_steps(const fs::path& log) {
  constexpr std::string_view kInfo = " info ";
  constexpr std::string_view kBegins = ": begins";
  LoggedSteps steps;
  std::ifstream file(log);
  for (std::string line; std::getline(file, line);) {
    const std::size_t begins = line.find(kBegins);
    const std::size_t info = line.find(kInfo);
    if (begins == std::string::npos || info == std::string::npos || info > begins) continue;
    steps.last = line.substr(info + kInfo.size(), begins - info - kInfo.size());
    std::uint64_t total = 0;
    const std::size_t at = begins + kBegins.size() + 2;  // ", "
    if (at < line.size()) std::from_chars(line.data() + at, line.data() + line.size(), total);
    steps.totals[steps.last] = total;
  }
  return steps;
}

StageStatus stage_status(const fs::path& work_dir, const std::string& stage, std::uint64_t total) {
  const Results results = results_of(work_dir / stage);
  return {stage, results.committed, results.in_flight, total,
          total > 0 && results.committed == total};
}

/// A stage that is done when its document is there; its results may have gone since.
StageStatus documented_stage(const fs::path& work_dir, const std::string& stage,
                             const char* document, std::uint64_t total) {
  StageStatus status = stage_status(work_dir, stage, total);
  status.done = total > 0 && fs::exists(work_dir / stage / document);
  if (status.done) status.chunks_done = total;
  return status;
}

/// Passes over raw points; gone once the points are cut into chunks for good.
void add_raw_stages(const fs::path& work_dir, const LoggedSteps& steps, WorkStatus& status) {
  std::uint64_t total = chunks_of(work_dir / raw_stages().front() / "partition.json");
  if (total == 0 && steps.last == "raw sort") total = steps.totals.at("raw sort");
  for (const std::string& stage : raw_stages()) {
    if (!fs::exists(work_dir / stage)) continue;
    const bool first = stage == raw_stages().front();
    status.stages.push_back(
        stage == kPatchStage
            ? stage_status(work_dir, stage, total)
            : documented_stage(work_dir, stage, first ? "partition.json" : "ended.json", total));
  }
}

}  // namespace

WorkStatus work_status(const fs::path& work_dir) {
  if (!fs::exists(work_dir / "orbweave-store.json")) {
    throw_usage("is no work directory of orbweave",
                {.file = work_dir.string(),
                 .place = {},
                 .found = fs::exists(work_dir) ? "no orbweave-store.json in it" : "nothing there",
                 .expected = "the work_dir of a job",
                 .advice = {}});
  }
  WorkStatus status;
  status.running = is_locked(work_dir / kOwnerLock);
  std::ifstream(work_dir / kOwnerLock) >> status.process_id;
  status.members = members_at_work(work_dir);
  status.ended = fs::exists(work_dir / "ended.json");
  const LoggedSteps steps = logged_steps(work_dir / "orbweave.log");
  status.step = steps.last;
  std::uint64_t total = chunks_of(work_dir / kPointsStage / "partition.json");
  if (total == 0) add_raw_stages(work_dir, steps, status);
  if (total == 0 && steps.last == "sort") total = steps.totals.at("sort");
  status.stages.push_back(documented_stage(work_dir, kPointsStage, "partition.json", total));
  status.stages.push_back(stage_status(work_dir, kMeshStage, total));
  const fs::path holes = work_dir / kHoleStage;
  if (fs::exists(holes)) {
    const std::uint64_t batches = batches_of(holes / "batches.json.json");
    status.stages.push_back(stage_status(work_dir, kHoleStage, batches));
    if (batches == 0 && status.ended) status.stages.back().done = true;  // there was none to fill
  }
  status.last_touched = last_touched(work_dir);
  return status;
}

}  // namespace orbweave
