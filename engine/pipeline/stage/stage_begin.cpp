#include "engine/pipeline/stage/stage_begin.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "io/error.h"
#include "io/job/job_keys.h"
#include "io/job/simplified_file.h"
#include "io/meshes/heavy_data.h"
#include "io/meshes/tile_directory.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/report.h"
#include "io/system/file_sample.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// Whether anything is stored of a stage beside its key.
bool holds_anything(const ChunkStore& store, const std::string& stage) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(store.directory() / stage, ignored))
    if (entry.path().filename() != "key.json") return true;
  return false;
}

std::string enumerated(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

/// Removes the results of a stage and of those after it; returns what people call them.
std::vector<std::string> discard_from(ChunkStore& store, const std::string& stage) {
  std::vector<std::string> removed;
  for (const std::string& later : directories_from(stage)) {
    const StageInfo* info = stage_in(later);
    const std::string name = info == nullptr ? later : info->results;
    if (holds_anything(store, later) &&
        std::find(removed.begin(), removed.end(), name) == removed.end())
      removed.push_back(name);
    store.discard_stage(later);
  }
  return removed;
}

constexpr const char* kChanged = "a scan changed while it was read";

[[noreturn]] void throw_changed(const std::string& file, const std::string& found) {
  throw_bad_input(kChanged, {.file = file,
                             .place = {},
                             .found = found,
                             .expected = "files that stay as they are while the job runs",
                             .advice = "Run the same command again when they do"});
}

/// An output that cannot be read is none of this job's, and is written anew.
InputStamp stamp_of_output(const std::string& file) {
  try {
    return stamp_of(file, kSampleBlocks);
  } catch (const Error& error) {
    InputStamp stamp;
    stamp.file = file;
    stamp.problem = error.what();
    return stamp;
  }
}

/// What a directory of outputs holds, by number, sizes and the latest change: there may be
/// thousands of files, of which none is read.
InputStamp stamp_of_directory(const fs::path& directory) {
  InputStamp stamp;
  stamp.file = directory.string();
  std::uint64_t files = 0;
  auto latest = fs::file_time_type::min();
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, failed)) {
    const std::uint64_t bytes = entry.file_size(failed);
    const fs::file_time_type time = entry.last_write_time(failed);
    if (failed) continue;
    ++files;
    stamp.bytes += bytes;
    latest = std::max(latest, time);
  }
  stamp.modified = std::to_string(latest.time_since_epoch().count());
  stamp.sample = std::to_string(files) + " files";
  return stamp;
}

bool is_of_raw_points(const std::string& stage) {
  const StageInfo* info = stage_in(stage);
  return info != nullptr && info->line == StageLine::kRaw;
}

[[noreturn]] void throw_gone(const ChunkStore& store, const std::string& stage) {
  throw_resource("the work directory is gone, or cannot be read",
                 {.file = (store.directory() / stage).string(),
                  .place = {},
                  .found = "nothing of what this run left there",
                  .expected = "a directory that no other program touches",
                  .advice = "The same command starts over"});
}

}  // namespace

std::string stored_key(const ChunkStore& store, const std::string& stage) {
  std::optional<std::string> key = store.key(stage);
  std::error_code ignored;
  if (!key && !fs::exists(store.directory() / stage, ignored)) throw_gone(store, stage);
  if (!key) throw CorruptResult(store.directory() / stage / "key.json", "no key of the stage");
  return std::move(*key);
}

bool holds_points(const ChunkStore& store, const std::string& stage, const std::string& key) {
  const std::optional<std::string> stored = store.key(stage);
  return stored && serve_for(*stored, key) && stored_partition(store, stage).has_value();
}

void begin_anew(StageRunner& runner, const std::string& stage, const std::string& key,
                const std::string& reason) {
  const std::vector<std::string> removed = discard_from(runner.store, stage);
  if (!removed.empty() && !reason.empty()) {
    const bool one = removed.size() == 1 && removed.front() == "mesh";
    runner.note(reason + ": " + enumerated(removed) + (one ? " is" : " are") + " computed again");
  }
  runner.store.begin_stage(stage, key);
}

void begin_stage(StageRunner& runner, const std::string& stage, const std::string& key) {
  if (runner.store.has_key(stage, key)) return;
  const std::optional<std::string> before = runner.store.key(stage);
  const std::string unknown = "it is not known any more what they were made from";
  std::string reason = before ? key_changes(*before, key) : unknown;
  if (before && stage == kPointsStage) runner.change_of_points = reason;
  // Which passes there are, and what each depends on, follows from what the points depend on.
  if (is_of_raw_points(stage) && !runner.change_of_points.empty()) reason = runner.change_of_points;
  begin_anew(runner, stage, key, reason);
}

std::string reason_not_to_fit(const ResolvedJob& job, std::uint64_t made_for, std::uint64_t largest,
                              std::uint64_t points, const PointSchema& schema) {
  const std::uint64_t budget = job.partition.memory_bytes;
  if (budget >= made_for) return {};
  const MemoryPlan plan = job.memory_plan(points, schema);
  if (largest * MemoryCosts::kReconstructBytes <= plan.chunks_in_flight_bytes) return {};
  return "partition.memory changed from " +
         value_text(static_cast<std::int64_t>(made_for), JobKeyType::kBytes) + " to " +
         value_text(static_cast<std::int64_t>(budget), JobKeyType::kBytes) + ", which chunks of " +
         format_count(largest) + " points do not fit";
}

void drop_what_does_not_fit(StageRunner& runner, const std::string& stage, const std::string& key) {
  const std::optional<Partition> stored = stored_partition(runner.store, stage);
  if (!stored) return;
  std::uint64_t largest = 0;
  for (ChunkId chunk = 0; chunk < stored->octree.chunks().size(); ++chunk)
    largest = std::max(largest, stored->points_in(chunk));
  const std::string reason = reason_not_to_fit(runner.job, stored->memory_bytes, largest,
                                               stored->points(), stored->schema);
  if (!reason.empty()) begin_anew(runner, stage, key, reason);
}

void check_unchanged(const StageRunner& runner, const std::string& stage) {
  ResolvedJob job = runner.job;
  job.inputs = stamps_of_inputs(job);
  const std::string now = stage == kPointsStage ? points_key(job) : raw_points_key(job);
  if (runner.store.has_key(stage, now)) return;
  if (!runner.store.key(stage)) throw_gone(runner.store, stage);
  throw_changed(runner.job.files.front(), key_changes(runner.store.key(stage).value_or(now), now));
}

void tell_of_changed_input(const ResolvedJob& job, const Error& error) {
  if (error.kind() != ErrorKind::kBadInput || error.problem() == kChanged) return;
  const std::vector<InputStamp> now = stamps_of_inputs(job);
  for (std::size_t i = 0; i < std::min(now.size(), job.inputs.size()); ++i)
    if (now[i].text() != job.inputs[i].text())
      throw_changed(now[i].file,
                    job.inputs[i].text() + " before, " + now[i].text() + " now: " + error.what());
}

std::vector<InputStamp> stamps_of_outputs(const Job& job) {
  const OutputOptions& output = job.output;
  const std::string mesh =
      output.tiles ? (tile_directory_of(output.mesh) / kTileIndex).string() : output.mesh;
  std::vector<InputStamp> stamps;
  for (const std::string& file :
       {mesh, heavy_data_file(mesh).string(), coordinate_system_file(output.mesh).string(),
        output.polygons, output.medial_axis, output.report, report_page(output.report).string(),
        output.picture, simplified_file(output).string(),
        heavy_data_file(simplified_file(output)).string()})
    if (!file.empty()) stamps.push_back(stamp_of_output(file));
  if (output.tiles) stamps.push_back(stamp_of_directory(tile_directory_of(output.mesh)));
  if (!output.tileset.empty()) {
    stamps.push_back(stamp_of_output((fs::path(output.tileset) / kTileIndex).string()));
    stamps.push_back(stamp_of_directory(output.tileset));
  }
  return stamps;
}

}  // namespace orbweave
