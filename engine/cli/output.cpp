#include "engine/cli/output.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "io/error.h"
#include "io/job/job_keys.h"
#include "io/job/setting.h"
#include "io/report/hole_summary.h"
#include "io/shown_text.h"
#include "io/system/file_descriptor.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

bool colour_on_stderr() {
  const char* no_colour = std::getenv("NO_COLOR");
  return (no_colour == nullptr || *no_colour == '\0') && isatty(STDERR_FILENO) == 1;
}

void print_labelled(const char* label, const char* colour, const std::string& what) {
  std::cout.flush();
  std::string line = "orbweave: ";
  line += colour_on_stderr() ? colour + std::string(label) + "\033[0m" : label;
  line += shown(what) + "\n";
  std::cerr << line << std::flush;
}

std::string padded(const std::string& text, std::size_t width, bool left) {
  const std::string blanks(width > text.size() ? width - text.size() : 0, ' ');
  return left ? text + blanks : blanks + text;
}

/// Reasons name keys of a job; of a job from the command line these are options.
std::string with_settings(const Job& job, std::string text) {
  for (const JobKey& key : job_keys())
    if (const std::size_t at = text.find(key.name()); at != std::string::npos)
      text.replace(at, key.name().size(), setting_name(job, key.name()));
  return text;
}

std::string fixed(double value, int decimals) {
  std::array<char, 400> text{};  // the largest double has 309 digits
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed, decimals);
  return {text.data(), end.ptr};
}

}  // namespace

void print_error(const std::string& what) { print_labelled("error: ", "\033[1;31m", what); }
void print_warning(const std::string& what) { print_labelled("warning: ", "\033[1;33m", what); }

void flush_output() {
  errno = 0;
  std::cout.flush();
  if (std::cout) return;
  const int reason = errno;
  throw_resource("cannot write to standard output",
                 {.found = reason != 0 ? system_reason(reason) : std::string()});
}

std::string facts_table(const Facts& facts) {
  std::size_t width = 0;
  for (const auto& fact : facts) width = std::max(width, fact.first.size());
  std::string text;
  for (const auto& [name, value] : facts)
    text += padded(name, width + 2, true) + shown(value) + "\n";
  return text;
}

std::string table(std::vector<std::vector<std::string>> rows) {
  std::vector<std::size_t> widths;
  for (auto& row : rows) {
    for (std::string& cell : row) cell = shown(cell);
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (const auto& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c)
      text += (c == 0 ? "" : "  ") + padded(row[c], widths[c], c == 0);
    text += "\n";
  }
  return text;
}

std::string distance_table(const std::vector<std::pair<std::string, DistanceSummary>>& rows) {
  std::vector<std::vector<std::string>> cells = {
      {"distances", "points", "measured", "mean", "rms", "median", "95 %", "largest"}};
  for (const auto& [name, d] : rows) {
    cells.push_back({name, format_count(d.points), format_count(d.measured)});
    for (const double value : {d.mean, d.rms, d.median, d.percentile_95, d.max})
      cells.back().push_back(d.measured > 0 ? format_number(value) : "-");
  }
  return table(cells);
}

std::string show_percent(double share) { return format_number(100.0 * share) + " %"; }

std::string within_table(std::span<const NearShare> shares) {
  if (shares.empty()) return "";
  std::vector<std::vector<std::string>> rows = {{"within", "precision", "recall", "F-score"}};
  for (const NearShare& share : shares)
    rows.push_back({format_number(share.distance), show_percent(share.precision),
                    show_percent(share.recall), show_percent(share.f_score)});
  return "\n" + table(rows);
}

std::string show_box(const Box& box) {
  if (box.empty()) return "none";
  const Vec3 extent = box.extent();
  const double largest = box.largest_extent();
  constexpr int kMostDecimals = 12;
  constexpr double kMostWhole = 1e15;  // beyond, digits before the point mean nothing
  const int decimals =
      largest > 0.0 ? std::max(5 - static_cast<int>(std::floor(std::log10(largest))), 0) : 6;
  // Of a box that is small beside 1, these decimals would be zeros, and so they would of a point.
  const double least = largest > 0.0 ? 0.0 : std::pow(10.0, -decimals);
  const auto coordinate = [&](double value) {
    const double magnitude = std::abs(value);
    const bool is_plain = decimals <= kMostDecimals && magnitude < kMostWhole &&
                          (magnitude >= least || magnitude == 0.0);
    return is_plain ? fixed(value, decimals) : format_exact(value);
  };
  std::string text;
  for (int axis = 0; axis < 3; ++axis)
    text +=
        (axis == 0 ? "" : ", ") + coordinate(box.min[axis]) + " .. " + coordinate(box.max[axis]);
  return text + " (" + format_number(extent.x) + " x " + format_number(extent.y) + " x " +
         format_number(extent.z) + ")";
}

std::string counted(std::uint64_t count, const char* one, const char* many) {
  return format_count(count) + " " + (count == 1 ? one : many);
}

std::string show_counts(std::uint64_t vertices, std::uint64_t triangles) {
  return counted(vertices, "vertex", "vertices") + ", " +
         counted(triangles, "triangle", "triangles");
}

std::string show_mesh(const MeshFacts& mesh) {
  const std::string border = mesh.watertight
                                 ? "closed"
                                 : counted(mesh.boundary_edges, "border edge", "border edges") +
                                       " in " + counted(mesh.boundary_loops, "loop", "loops");
  const std::uint64_t crossing =
      mesh.crossing_pairs.value_or(mesh.patch_crossing_pairs.value_or(0));
  return show_counts(mesh.vertices, mesh.triangles) + ", " + border +
         (crossing > 0 ? ", " + counted(crossing, "pair", "pairs") + " of triangles that cross"
                       : "");
}

void add_removed(Facts& facts, std::uint64_t pieces, std::uint64_t triangles) {
  if (pieces == 0) return;
  facts.emplace_back("removed", counted(pieces, "piece", "pieces") + " of " +
                                    counted(triangles, "triangle", "triangles"));
}

void add_dropped(Facts& facts, const DroppedPoints& dropped) {
  const Counted counts(dropped.begin(), dropped.end());
  const std::uint64_t sum = sum_of(counts);
  if (sum == 0) return;
  facts.emplace_back("dropped",
                     counted(sum, "point", "points") + ": " + counted_list(counts, counts.size()));
}

void add_unused(Facts& facts, std::uint64_t points) {
  if (points == 0) return;
  facts.emplace_back("unused",
                     counted(points, "point", "points") + " of the scan that no triangle uses");
}

void add_holes(Facts& facts, std::span<const HoleFacts> holes, const MeshFacts& mesh,
               const Job& job) {
  constexpr std::size_t kReasons = 5;
  if (holes.empty()) return;
  const HoleSummary found = hole_summary(holes);
  facts.emplace_back("loops", format_count(found.loops));
  if (found.filled > 0)
    facts.emplace_back("filled", format_count(found.filled) + " (" +
                                     counted_list(found.methods, found.methods.size()) + "), " +
                                     counted(found.points_added, "point", "points") + " and " +
                                     counted(found.triangles_added, "triangle", "triangles") +
                                     " added");
  if (found.filled > 0 && mesh.area > 0.0)
    facts.emplace_back("", fixed(100.0 * mesh.patch_area / mesh.area, 1) +
                               " % of the mesh's area is filled: no point of the scan supports it");
  if (found.doubtful > 0 && mesh.area > 0.0)
    facts.emplace_back("", counted(found.doubtful, "patch is", "patches are") + " doubtful, " +
                               fixed(100.0 * found.doubtful_area / mesh.area, 1) +
                               " % of the mesh's area; look first near " +
                               format_position(found.most_doubtful));
  if (found.partly > 0)
    facts.emplace_back("", counted(found.open_edges, "edge", "edges") + " of " +
                               counted(found.partly, "filled hole", "filled holes") +
                               " open, where every patch would cross the surface");
  if (mesh.mended_triangles > 0)
    facts.emplace_back("mended", counted(mesh.mended_triangles, "triangle", "triangles") +
                                     " of the scan taken out so that holes are closed soundly");
  if (mesh.pinches.value_or(0) > 0)
    facts.emplace_back("pinched", "sheets touch in " + counted(*mesh.pinches, "point", "points") +
                                      ", where vertices are doubled");
  for (std::size_t i = 0; i < std::min(kReasons, found.reasons.size()); ++i)
    facts.emplace_back(i == 0 ? "left open" : "", format_count(found.reasons[i].second) + ": " +
                                                      with_settings(job, found.reasons[i].first));
  if (found.reasons.size() > kReasons)
    facts.emplace_back("", "and others, for other reasons; the report has all");
}

}  // namespace orbweave
