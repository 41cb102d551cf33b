#include "engine/pipeline/stage_keys.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <map>

#include "engine/pipeline/patch_batch.h"
#include "engine/pipeline/prepare_stage.h"
#include "engine/pipeline/reconstruct_stage.h"
#include "engine/pipeline/scan_input.h"
#include "engine/pipeline/stitch_stage.h"
#include "io/chunk_points.h"
#include "io/job_keys.h"
#include "io/job_values.h"
#include "io/quantity.h"
#include "io/tile_directory.h"
#include "partition/memory_plan.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

std::string line_of(const JobKey& known, const Job& job) {
  return key_line(known.name(), value_text(known.get(job), known.type));
}

/// All keys of a section but some.
std::string section_lines(const Job& job, std::string_view section,
                          std::span<const std::string_view> but) {
  std::string lines;
  for (const JobKey& known : job_keys()) {
    if (section != known.section || std::find(but.begin(), but.end(), known.key) != but.end())
      continue;
    lines += line_of(known, job);
  }
  return lines;
}

std::string option_line(const Job& job, std::string_view name) {
  for (const JobKey& known : job_keys())
    if (known.name() == name) return line_of(known, job);
  return {};
}

std::string time_text(fs::file_time_type time) {
  const auto system = std::chrono::file_clock::to_sys(time);
  const auto seconds = std::chrono::floor<std::chrono::seconds>(system);
  const std::time_t whole = std::chrono::system_clock::to_time_t(
      std::chrono::time_point_cast<std::chrono::system_clock::duration>(seconds));
  std::tm utc{};
  gmtime_r(&whole, &utc);
  std::array<char, 40> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &utc);
  const auto rest = std::chrono::duration_cast<std::chrono::nanoseconds>(system - seconds).count();
  std::string digits = std::to_string(rest);
  digits.insert(0, 9 - std::min<std::size_t>(9, digits.size()), '0');
  return text.data() + ("." + digits) + "Z";
}

/// A file as it is now.
std::string stamp(const std::string& file) {
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) return error.message();
  const auto time = fs::last_write_time(file, error);
  return std::to_string(size) + " bytes" + (error ? "" : " of " + time_text(time));
}

std::string file_lines(const InputContext& context) {
  std::string lines;
  for (const std::string& file : context.files) lines += key_line(file, stamp(file));
  const std::string& poses = context.job.input.poses;
  if (!poses.empty()) lines += key_line(poses, stamp(poses));
  return lines;
}

/// What reading the scans and cutting them into chunks depends on.
std::string scan_lines(const InputContext& context) {
  const Job& job = context.job;
  constexpr std::array<std::string_view, 2> kNotTheirs = {"files", "units_per_meter"};
  std::string lines = file_lines(context) + section_lines(job, "input", kNotTheirs);
  lines += option_line(job, "partition.chunk_points") + option_line(job, "output.attributes");
  // Automatic radii are measured with the points.
  const bool automatic = job.reconstruct.ball_radii.empty();
  lines += automatic ? option_line(job, "reconstruct.levels")
                     : key_line("reconstruct.levels", "not used");
  return lines;
}

std::string normal_lines(const Job& job) {
  return option_line(job, "normals.source") + option_line(job, "normals.neighbors");
}

/// What people call the results of a stage.
std::string name_of_results(const std::string& stage) {
  static const std::map<std::string, std::string> names = {{"raw", "raw points"},
                                                           {"raw_outliers", "outliers"},
                                                           {"raw_merged", "merged points"},
                                                           {"raw_normals", "normals"},
                                                           {"raw_thinned", "thinned points"},
                                                           {"raw_patches", "orientation"},
                                                           {kStitchStage, kMeshStage},
                                                           {kHoleStage, "holes"}};
  if (stage.starts_with("raw_smooth")) return "smoothed points";
  const auto found = names.find(stage);
  return found == names.end() ? stage : found->second;
}

/// The stage and all after it.
std::vector<std::string> stages_from(const std::string& stage) {
  // The points' own key tells whether they can stay when raw points are made anew.
  std::vector<std::string> all = {kPointsStage, kMeshStage, kStitchStage, kHoleStage};
  if (stage.starts_with("raw")) all = raw_stages();
  all.erase(all.begin(), std::find(all.begin(), all.end(), stage));
  return all;
}

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
  for (const std::string& later : stages_from(stage)) {
    const std::string name = name_of_results(later);
    if (holds_anything(store, later) &&
        std::find(removed.begin(), removed.end(), name) == removed.end())
      removed.push_back(name);
    store.discard_stage(later);
  }
  return removed;
}

using Lines = std::map<std::string, std::string, std::less<>>;

Lines lines_of(std::string_view key) {
  Lines lines;
  constexpr std::string_view kIs = " = ";
  while (!key.empty()) {
    const std::string_view text = key.substr(0, key.find('\n'));
    key.remove_prefix(std::min(key.size(), text.size() + 1));
    const std::size_t is = text.find(kIs);
    if (is == std::string_view::npos)
      lines.emplace(text, "");
    else
      lines.emplace(text.substr(0, is), text.substr(is + kIs.size()));
  }
  return lines;
}

/// A change of one line; a line is there or it is not.
std::string change(const std::string& name, const std::string* before, const std::string* after) {
  if (before == nullptr) return name + " is new" + (after->empty() ? "" : " (" + *after + ")");
  if (after == nullptr) return name + " is no longer there";
  return name + " changed from " + *before + " to " + *after;
}

}  // namespace

std::string key_line(const std::string& name, const std::string& value) {
  return name + " = " + value + "\n";
}

std::string chunks_line(const Partition& partition) {
  std::uint64_t mixed = 0;
  for (const std::uint64_t first : partition.first_vertex)
    mixed = (mixed ^ first) * 0x9e3779b97f4a7c15u;
  return key_line("chunks", std::to_string(partition.octree.chunks().size()) + " (" +
                                std::to_string(mixed) + ")");
}

std::string raw_points_key(const InputContext& context) {
  const Orientation side = context.job.normals.orientation;
  const bool views = side == Orientation::kAuto || side == Orientation::kScanner;
  return key_line("layout of raw points", "3") + scan_lines(context) + normal_lines(context.job) +
         key_line("scanners needed", views ? "yes" : "no");
}

std::string points_key(const InputContext& context) {
  const Job& job = context.job;
  std::string key = key_line("layout of points", "3") + scan_lines(context);
  key += needs_preparation(context)
             ? section_lines(job, "prepare", {}) + section_lines(job, "normals", {})
             : option_line(job, "normals.source");
  return key;
}

std::string mesh_key(const JobContext& context, const Partition& partition,
                     const std::vector<double>& radii) {
  std::string values;
  for (const double radius : radii) values += (values.empty() ? "" : ", ") + format_exact(radius);
  // The scans may have changed, or gone, since the points were read: these are what counts.
  const std::string points = context.store.key(kPointsStage).value_or(std::string());
  return points + chunks_line(partition) + key_line("layout of the mesh", "3") +
         key_line("reconstruct.method",
                  std::to_string(static_cast<int>(context.job.reconstruct.method))) +
         key_line("reconstruct.ball_radii", "[" + values + "]");
}

std::string stitch_key(const JobContext& context, const Partition& partition,
                       const std::vector<double>& radii) {
  return mesh_key(context, partition, radii) + key_line("layout of the stitch", "1") +
         key_line("boundary", context.job.fill.enabled ? "kept" : "counted");
}

std::string hole_key(const JobContext& context, const Partition& partition,
                     const std::vector<double>& radii) {
  constexpr std::array<std::string_view, 1> kNotTheirs = {"enabled"};
  return mesh_key(context, partition, radii) + key_line("layout of holes", "2") +
         section_lines(context.job, "fill", kNotTheirs);
}

std::string outputs_key(const InputContext& context) {
  std::string key = file_lines(context);
  constexpr std::array<std::string_view, 1> kFiles = {"files"};
  constexpr std::array<std::string_view, 1> kBudget = {"memory"};
  key += section_lines(context.job, "input", kFiles);
  key += section_lines(context.job, "partition", kBudget);
  for (const char* section : {"prepare", "normals", "reconstruct", "fill", "output"})
    key += section_lines(context.job, section, {});
  const OutputOptions& output = context.job.output;
  const std::string mesh =
      output.tiles ? (tile_directory_of(output.mesh) / kTileIndex).string() : output.mesh;
  for (const std::string& file : {mesh, output.report, output.picture})
    if (!file.empty()) key += key_line(file, stamp(file));
  return key;
}

std::string key_changes(std::string_view before, std::string_view after) {
  const Lines from = lines_of(before);
  const Lines to = lines_of(after);
  std::vector<std::string> changes;
  for (const auto& [name, value] : from) {
    const auto now = to.find(name);
    if (now == to.end())
      changes.push_back(change(name, &value, nullptr));
    else if (now->second != value)
      changes.push_back(change(name, &value, &now->second));
  }
  for (const auto& [name, value] : to)
    if (!from.contains(name)) changes.push_back(change(name, nullptr, &value));
  if (changes.empty()) return "the scans are in another order";
  constexpr std::size_t kMost = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(changes.size(), kMost); ++i)
    text += (i == 0 ? "" : "; ") + changes[i];
  if (changes.size() > kMost)
    text += "; and " + std::to_string(changes.size() - kMost) + " more changes";
  return text;
}

void begin_anew(JobContext& context, const std::string& stage, const std::string& key,
                const std::string& reason) {
  const std::vector<std::string> removed = discard_from(context.store, stage);
  if (!removed.empty() && !reason.empty()) {
    const bool one = removed.size() == 1 && removed.front() == "mesh";
    context.note(reason + ": " + enumerated(removed) + (one ? " is" : " are") + " computed again");
  }
  context.store.begin_stage(stage, key);
}

void begin_stage(JobContext& context, const std::string& stage, const std::string& key) {
  if (context.store.has_key(stage, key)) return;
  const std::optional<std::string> before = context.store.key(stage);
  begin_anew(context, stage, key, before ? key_changes(*before, key) : std::string());
}

std::string reason_not_to_fit(const InputContext& context, std::uint64_t made_for,
                              std::uint64_t largest, std::uint64_t points,
                              const PointSchema& schema) {
  const std::uint64_t budget = context.job.partition.memory_bytes;
  if (budget >= made_for || context.job.partition.chunk_points != 0) return {};
  const MemoryPlan plan = plan_memory(budget, points, context.threads(), 0, schema);
  if (largest * MemoryCosts::kReconstructBytes <= plan.chunks_in_flight_bytes) return {};
  return "partition.memory changed from " +
         value_text(static_cast<std::int64_t>(made_for), JobKeyType::kBytes) + " to " +
         value_text(static_cast<std::int64_t>(budget), JobKeyType::kBytes) + ", which chunks of " +
         format_count(largest) + " points do not fit";
}

void drop_what_does_not_fit(JobContext& context, const std::string& stage, const std::string& key) {
  const std::optional<Partition> stored = stored_partition(context.store, stage);
  if (!stored) return;
  std::uint64_t largest = 0;
  for (ChunkId chunk = 0; chunk < stored->octree.chunks().size(); ++chunk)
    largest = std::max(largest, stored->points_in(chunk));
  const std::string reason =
      reason_not_to_fit(context, stored->memory_bytes, largest, stored->points(), stored->schema);
  if (!reason.empty()) begin_anew(context, stage, key, reason);
}

void check_unchanged(const JobContext& context, const std::string& stage) {
  const std::string now = stage == kPointsStage ? points_key(context) : raw_points_key(context);
  if (context.store.has_key(stage, now)) return;
  if (!context.store.key(stage))
    throw_resource("the work directory is gone, or cannot be read",
                   {.file = (context.store.directory() / stage).string(),
                    .place = {},
                    .found = "nothing of what this run left there",
                    .expected = "a directory that nobody else touches",
                    .advice = "The same command starts over"});
  throw_bad_input("a scan changed while it was read",
                  {.file = context.files.front(),
                   .place = {},
                   .found = key_changes(context.store.key(stage).value_or(now), now),
                   .expected = "files that stay as they are while the job runs",
                   .advice = "Run the same command again when they do"});
}

}  // namespace orbweave
