#include "engine/pipeline/stage/stage_keys.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "engine/normals/normal_side.h"
#include "engine/pipeline/stage/method_costs.h"
#include "io/job/job_keys.h"
#include "io/job/job_values.h"
#include "io/shown_text.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr const char* kLevels = "reconstruct.levels";

/// Of a job that gives its radii.
std::string levels_not_used() { return key_line(kLevels, "not used"); }

std::string line_of(const JobKey& known, const Job& job) {
  return key_line(stored_key_name(known.name()), value_text(known.get(job), known.type));
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

std::string stamp_lines(std::span<const InputStamp> stamps) {
  std::string lines;
  for (const InputStamp& stamp : stamps) lines += key_line(shown(stamp.file), stamp.text());
  return lines;
}

/// Empty: nothing beside the scans counts.
std::string beside_line(const ResolvedJob& job) {
  if (job.beside_scans.empty()) return {};
  return key_line("beside the scans", shown(job.beside_scans));
}

/// What reading the scans and cutting them into chunks depends on.
std::string scan_lines(const ResolvedJob& job) {
  constexpr std::array<std::string_view, 2> kNotTheirs = {"files", "units_per_meter"};
  std::string lines = stamp_lines(job.inputs) + section_lines(job, "input", kNotTheirs);
  lines += beside_line(job) + option_line(job, "partition.chunk_points") +
           option_line(job, "output.attributes");
  if (is_cocone(job.reconstruct.method))
    lines += key_line("cut", "for cocone") + option_line(job, "partition.memory") +
             option_line(job, "reconstruct.method");
  else if (is_in_core(job.reconstruct.method))
    lines += key_line("cut", "one chunk");
  // Automatic radii are measured with the points.
  const bool automatic = job.reconstruct.ball_radii.empty();
  lines += automatic ? option_line(job, kLevels) : levels_not_used();
  return lines;
}

std::string normal_lines(const Job& job) {
  return option_line(job, "normals.source") + option_line(job, "normals.neighbors");
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

/// The lines that the keys of a job have at their defaults.
Lines default_lines() {
  const Job job;
  std::string lines;
  for (const JobKey& known : job_keys()) lines += line_of(known, job);
  return lines_of(lines);
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

std::string raw_points_key(const ResolvedJob& job) {
  const Orientation side = job.normals.orientation;
  const bool views = asks_for_scanner(side);
  const bool is_one_chunk = job.normals.source == NormalSource::kPoles;
  return key_line("layout of raw points", "12") + scan_lines(job) + normal_lines(job) +
         (is_one_chunk ? key_line("cut of raw points", "one chunk") : std::string()) +
         key_line("scanners needed", views ? "yes" : "no");
}

std::string points_key(const ResolvedJob& job) {
  std::string key = key_line("layout of points", "15") + scan_lines(job) +
                    option_line(job, "output.vertex_quality");
  key += job.needs_cleaning_or_normals()
             ? section_lines(job, "cleaning", {}) + section_lines(job, "normals", {})
             : option_line(job, "normals.source");
  return key;
}

bool serve_for(std::string_view stored, std::string_view wanted) {
  if (stored == wanted) return true;
  std::string adapted(stored);
  const std::string begin = std::string("\n") + kLevels + " = ";
  const std::size_t line = adapted.find(begin);
  if (line == std::string::npos) return false;
  const std::size_t end = adapted.find('\n', line + 1);
  if (end == std::string::npos) return false;
  adapted.replace(line + 1, end - line, levels_not_used());
  return adapted == wanted;
}

std::string mesh_key(const ResolvedJob& job, const std::string& points_key,
                     const Partition& partition, std::span<const double> radii) {
  std::string values;
  for (const double radius : radii) values += (values.empty() ? "" : ", ") + format_exact(radius);
  if (is_in_core(job.reconstruct.method)) values += "; layout of the method 2";
  return points_key + chunks_line(partition) + key_line("layout of the mesh", "7") +
         key_line("reconstruct.method", std::to_string(static_cast<int>(job.reconstruct.method))) +
         key_line("reconstruct.ball_radii", "[" + values + "]");
}

std::string power_crust_key(const ResolvedJob& job, const std::string& points_key) {
  return points_key + key_line("layout of the Power Crust", "1") +
         option_line(job, "reconstruct.method");
}

std::string stitch_key(const ResolvedJob& job, const std::string& mesh_key) {
  return mesh_key + key_line("layout of the stitch", "5") +
         key_line("boundary", job.fill.enabled ? "kept" : "counted");
}

std::string hole_key(const ResolvedJob& job, const std::string& mesh_key) {
  constexpr std::array<std::string_view, 1> kNotTheirs = {"enabled"};
  return mesh_key + key_line("layout of holes", "25") + section_lines(job, "fill", kNotTheirs);
}

std::string check_key(const ResolvedJob& job, const std::string& mesh_key) {
  // The surface alone may be checked, too.
  return hole_key(job, mesh_key) + option_line(job, "fill.enabled") +
         key_line("layout of the check", "2") + option_line(job, "output.check_surface");
}

std::string outputs_key(const ResolvedJob& job, std::span<const InputStamp> outputs) {
  std::string key = stamp_lines(job.inputs) + beside_line(job);
  constexpr std::array<std::string_view, 1> kFiles = {"files"};
  constexpr std::array<std::string_view, 1> kBudget = {"memory"};
  key += section_lines(job, "input", kFiles);
  key += section_lines(job, "partition", kBudget);
  if (is_cocone(job.reconstruct.method)) key += option_line(job, "partition.memory");
  for (const char* section : {"cleaning", "normals", "reconstruct", "fill", "output"})
    key += section_lines(job, section, {});
  return key + stamp_lines(outputs);
}

std::string team_key(const Job& job) {
  constexpr std::array<std::string_view, 1> kOwn = {"memory"};
  std::string key = section_lines(job, "partition", kOwn);
  if (is_cocone(job.reconstruct.method)) key += option_line(job, "partition.memory");
  for (const char* section : {"input", "cleaning", "normals", "reconstruct", "fill", "output"})
    key += section_lines(job, section, {});
  return key;
}

std::string key_changes(std::string_view before, std::string_view after) {
  const Lines from = lines_of(before);
  const Lines to = lines_of(after);
  const Lines defaults = default_lines();
  std::vector<std::string> changes;
  std::vector<std::string> follow;  // lines of keys at their defaults
  const auto add = [&](const std::string& name, const std::string* was, const std::string* is) {
    const auto usual = defaults.find(name);
    const bool is_usual = usual != defaults.end() && (was == nullptr || is == nullptr) &&
                          usual->second == (was == nullptr ? *is : *was);
    (is_usual ? follow : changes).push_back(change(current_key_name(name), was, is));
  };
  for (const auto& [name, value] : from) {
    const auto now = to.find(name);
    if (now == to.end())
      add(name, &value, nullptr);
    else if (now->second != value)
      add(name, &value, &now->second);
  }
  for (const auto& [name, value] : to)
    if (!from.contains(name)) add(name, nullptr, &value);
  if (changes.empty()) changes = std::move(follow);
  if (changes.empty()) return "the scans are in another order";
  constexpr std::size_t kMost = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(changes.size(), kMost); ++i)
    text += (i == 0 ? "" : "; ") + changes[i];
  if (changes.size() > kMost)
    text += "; and " + std::to_string(changes.size() - kMost) + " more changes";
  return text;
}

}  // namespace orbweave
