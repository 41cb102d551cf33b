// What a work directory tells about the run that uses or used it.
#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/run_steps.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stages.h"
#include "io/error.h"
#include "io/json_nesting.h"
#include "io/store/chunk_points.h"
#include "io/store/store_lock.h"
#include "io/system/directory.h"
#include "io/system/file_descriptor.h"

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
  for (const fs::path& entry : entries_of(stage, ignored)) {
    const std::string name = entry.filename().string();
    if (name.ends_with(".h5.part")) ++results.in_flight;
    if (name.ends_with(".h5") && !name.starts_with(".")) ++results.committed;
  }
  return results;
}

/// False also where that cannot be told.
bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
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

/// A run removes files and folders meanwhile: what is gone, or cannot be listed, is passed over.
std::string last_touched(const fs::path& directory) {
  std::error_code failed;
  fs::file_time_type latest = fs::last_write_time(directory, failed);
  if (failed) latest = fs::file_time_type::clock::now();
  std::vector<fs::path> folders = {directory};
  while (!folders.empty()) {
    const fs::path folder = std::move(folders.back());
    folders.pop_back();
    for (fs::path& entry : entries_of(folder, failed)) {
      const fs::file_time_type time = fs::last_write_time(entry, failed);
      if (!failed) latest = std::max(latest, time);
      if (fs::is_directory(fs::symlink_status(entry, failed))) folders.push_back(std::move(entry));
    }
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
  const auto json = json_of(text_of(document));
  if (!json.is_object() || !json.contains("batches")) return 0;
  return json["batches"].is_number_unsigned() ? json["batches"].get<std::uint64_t>() : 0;
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
  status.done = total > 0 && is_there(work_dir / stage / document);
  if (status.done) status.chunks_done = total;
  return status;
}

StageStatus status_of(const fs::path& work_dir, const StageInfo& info, const std::string& directory,
                      std::uint64_t total) {
  if (*info.completed_by == '\0') return stage_status(work_dir, directory, total);
  return documented_stage(work_dir, directory, info.completed_by, total);
}

/// Chunks of a cloud that is cut, or of one that is being sorted; 0: not known yet.
std::uint64_t chunks_of(const fs::path& work_dir, const CutStages& stages, const RunStep& step) {
  const std::uint64_t chunks =
      chunks_of(work_dir / stages.points() / info_of(stages.sort).completed_by);
  return chunks == 0 && step.name == name_of(stages.sort) ? step.total : chunks;
}

/// Passes over raw points; gone once the points are cut into chunks for good.
void add_raw_stages(const fs::path& work_dir, const RunStep& step, WorkStatus& status) {
  const std::uint64_t total = chunks_of(work_dir, kRawCut, step);
  for (const std::string& directory : directories_of(StageLine::kRaw)) {
    const StageInfo* info = stage_in(directory);
    if (info == nullptr || !info->shown_by_status || !is_there(work_dir / directory)) continue;
    status.stages.push_back(status_of(work_dir, *info, directory, total));
  }
}

/// Batches take the place of chunks.
void add_holes(const fs::path& work_dir, WorkStatus& status) {
  const fs::path holes = work_dir / kHoleStage;
  if (!is_there(holes)) return;
  const std::uint64_t batches = batches_of(holes / "batches.json.json");
  status.stages.push_back(stage_status(work_dir, kHoleStage, batches));
  if (batches == 0 && status.ended) status.stages.back().done = true;  // there was none to fill
}

/// Nodes that are simplified take the place of chunks. How many there are in all, no result says.
void add_levels(const fs::path& work_dir, WorkStatus& status) {
  for (const Stage stage : {Stage::kTileset, Stage::kSimplify}) {
    if (!is_there(work_dir / directory_of(stage))) continue;
    status.stages.push_back(stage_status(work_dir, directory_of(stage), 0));
    // The mesh is simplified when the tileset is there.
    const bool is_behind = stage == Stage::kTileset && status.step == name_of(Stage::kSimplify);
    status.stages.back().done = status.ended || is_behind;
  }
}

std::optional<JobPace::Estimate> pace_of(const RunSteps& steps, const WorkStatus& status) {
  if (!steps.pace.is_known()) return std::nullopt;
  StageStatus at;
  for (const StageStatus& stage : status.stages) {
    const StageInfo* info = stage_in(stage.name);
    if (stage.name == steps.last.name || (info != nullptr && steps.last.name == info->name))
      at = stage;
  }
  return steps.pace.at(run_clock_seconds(), at.chunks_done, at.chunks_total);
}

void require_work_dir(const fs::path& work_dir) {
  std::error_code failed;
  if (fs::exists(work_dir / "orbweave-store.json", failed)) return;
  const bool is_known = !failed || failed == std::errc::not_a_directory;
  throw_usage("is no work directory of orbweave",
              {.file = work_dir.string(),
               .place = {},
               .found = !is_known            ? system_reason(failed.value())
                        : is_there(work_dir) ? "no orbweave-store.json in it"
                                             : "nothing there",
               .expected = "the work_dir of a job",
               .advice = {}});
}

}  // namespace

WorkStatus work_status(const fs::path& work_dir) {
  require_work_dir(work_dir);
  WorkStatus status;
  status.running = is_owned(work_dir);
  std::ifstream(work_dir / kOwnerLock) >> status.process_id;
  status.members = members_at_work(work_dir);
  status.ended = is_there(work_dir / "ended.json");
  const RunSteps steps = stored_steps(work_dir / kStepsName);
  const RunStep& step = steps.last;
  status.step = step.name;
  const std::uint64_t total = chunks_of(work_dir, kFinalCut, step);
  const bool is_cut = chunks_of(work_dir / kPointsStage / "partition.json") != 0;
  if (!is_cut) add_raw_stages(work_dir, step, status);
  for (const Stage stage : {Stage::kSort, Stage::kReconstruct})
    status.stages.push_back(status_of(work_dir, info_of(stage), directory_of(stage), total));
  add_holes(work_dir, status);
  add_levels(work_dir, status);
  if (status.running && !status.ended) status.pace = pace_of(steps, status);
  status.last_touched = last_touched(work_dir);
  return status;
}

}  // namespace orbweave
