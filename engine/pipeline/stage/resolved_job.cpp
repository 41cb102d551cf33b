#include "engine/pipeline/stage/resolved_job.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <set>
#include <utility>

#include "engine/normals/normal_side.h"
#include "engine/pipeline/stage/method_costs.h"
#include "io/clouds/open_point_source.h"
#include "io/clouds/trajectory_file.h"
#include "io/error.h"
#include "io/job/output_origin.h"
#include "io/job/selected_points.h"
#include "io/job/setting.h"
#include "io/meshes/shift_file.h"
#include "io/system/file_descriptor.h"
#include "io/system/file_sample.h"
#include "partition/executor.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

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

bool will_estimate_normals(const Job& job, const std::vector<std::string>& files) {
  switch (job.normals.source) {
    case NormalSource::kFile:
      return false;
    case NormalSource::kEstimate:
    case NormalSource::kPoles:
      return true;
    case NormalSource::kAuto:
      break;
  }
  // One scan without normals has all estimated, whatever the order of the scans.
  return std::ranges::any_of(files, [&](const std::string& file) {
    return !open_point_source(file, {job.input.text})->schema().has_normals;
  });
}

std::vector<InputStamp> stamps(const Job& job, std::vector<std::string> files) {
  if (!job.input.poses.empty()) files.push_back(job.input.poses);
  if (!job.input.trajectory.empty()) files.push_back(job.input.trajectory);
  if (names_area_file(job.input)) files.push_back(job.input.crop_area);
  std::vector<InputStamp> all;
  for (const std::string& file : files)
    all.push_back(stamp_of(file, sample_blocks_of(files.size())));
  return all;
}

/// Two keys would say where the scanner was.
void check_places_of_scanner(const Job& job) {
  if (job.input.trajectory.empty()) return;
  for (const auto& [is_given, key] : {std::pair(job.input.scanner.has_value(), "input.scanner"),
                                      std::pair(!job.input.scanners.empty(), "input.scanners")})
    if (is_given)
      throw_usage(setting_name(job, "input.trajectory") + " and " + setting_name(job, key) +
                      " both say where the scanner was",
                  {.expected = "one of them"});
}

std::shared_ptr<const Trajectory> trajectory_of(const InputOptions& input) {
  if (input.trajectory.empty()) return nullptr;
  require_rereadable(input.trajectory);
  return std::make_shared<const Trajectory>(read_trajectory(input.trajectory));
}

/// The coordinate systems that scans have from beside them, each text once: a mesh that has a
/// scan's name gets the same text; and the origins of those that have one.
std::string files_beside(const Job& job, const std::vector<std::string>& files) {
  std::set<std::string> texts;
  for (const std::string& file : files) {
    texts.insert(system_from_beside(file, {job.input.text}));
    const Vec3 origin = origin_beside(file);
    if (origin != Vec3{}) texts.insert(file + " counted from " + origin_text(origin));
  }
  std::string all;
  for (const std::string& text : texts)
    if (!text.empty()) all += (all.empty() ? "" : " and ") + text;
  std::ranges::replace(all, '\n', ' ');
  return all;
}

}  // namespace

std::string InputStamp::text() const {
  const std::string known = problem.empty() ? std::to_string(bytes) + " bytes" +
                                                  (modified.empty() ? "" : " of " + modified)
                                            : problem;
  return known + (sample ? ", sample " + *sample : std::string());
}

InputStamp stamp_of(const std::string& file, std::size_t blocks) {
  InputStamp stamp;
  stamp.file = file;
  std::error_code error;
  stamp.bytes = fs::file_size(file, error);
  if (error) {
    stamp.bytes = 0;
    stamp.problem = error.message();
  } else {
    const auto time = fs::last_write_time(file, error);
    if (!error) stamp.modified = time_text(time);
  }
  // A tool may give a file the time of another.
  if (std::optional<FileSample> sample = sample_file(file, blocks)) {
    stamp.sample = std::move(sample->fingerprint);
    stamp.bytes_hashed = sample->bytes_hashed;
  }
  return stamp;
}

int ResolvedJob::threads() const { return run.threads > 0 ? run.threads : available_threads(); }

bool ResolvedJob::cleans() const { return orbweave::cleans(cleaning); }

bool ResolvedJob::needs_cleaning_or_normals() const {
  return cleaning.automatic || cleans() || estimates_normals || output.vertex_quality;
}

bool ResolvedJob::wants_view() const {
  return estimates_normals && asks_for_scanner(normals.orientation);
}

Orientation ResolvedJob::orientation_rule(std::uint64_t points_without_view) const {
  return side_of_normals(normals, points_without_view);
}

MemoryPlan ResolvedJob::memory_plan(std::uint64_t points, const PointSchema& schema,
                                    std::uint64_t worthwhile_points) const {
  try {
    MemoryPlan plan = plan_memory(partition.memory_bytes, points, threads(), partition.chunk_points,
                                  schema, worthwhile_points);
    if (is_in_core(reconstruct.method)) plan.chunk_points = kOneChunkPoints;
    return plan;
  } catch (const Error& error) {
    ErrorParts parts = error.parts();
    parts.place = setting_name(*this, parts.place);
    throw Error(error.kind(), error.problem(), std::move(parts));
  }
}

ResolvedJob resolve(const Job& job, std::vector<std::string> files) {
  for (const std::string& file : files) require_rereadable(file);
  check_places_of_scanner(job);
  ResolvedJob resolved{job,
                       std::move(files),
                       {},
                       false,
                       job.input.pose,
                       area_of(job.input),
                       trajectory_of(job.input),
                       {}};
  resolved.inputs = stamps(job, resolved.files);
  resolved.beside_scans = files_beside(job, resolved.files);
  resolved.estimates_normals = will_estimate_normals(job, resolved.files);
  if (!job.input.poses.empty())
    for (ScanPose& pose : read_stanford_poses(job.input.poses))
      resolved.poses.push_back(std::move(pose));
  require_own_poses(resolved.poses, resolved.files);
  return resolved;
}

std::vector<InputStamp> stamps_of_inputs(const ResolvedJob& job) { return stamps(job, job.files); }

std::vector<TrustedFile> trusted_files(const ResolvedJob& job) {
  std::vector<TrustedFile> trusted;
  for (const InputStamp& input : job.inputs)
    if (input.problem.empty())
      trusted.push_back({input.file, input.bytes, input.modified, input.bytes_hashed});
  return trusted;
}

bool cleans(const CleaningOptions& options) {
  return options.outlier_sigma > 0.0 || options.merge_tolerance > 0.0 ||
         options.smooth_radius > 0.0 || options.thin_to_spacing > 0.0 ||
         options.cluster_points.value_or(0) > 0 || options.min_surfaceness > 0.0;
}

std::string work_dir_of(const Job& job) {
  if (!job.run.work_dir.empty()) return job.run.work_dir;
  if (job.output.mesh == "-") return "orbweave.work";
  return fs::path(job.output.mesh).replace_extension(".work").string();
}

}  // namespace orbweave
