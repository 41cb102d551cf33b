#include "io/report/report_html.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>
#include <vector>

#include "io/job/job_keys.h"
#include "io/report/hole_summary.h"
#include "io/report/machine.h"
#include "io/report/reasons.h"
#include "io/report/verdict.h"
#include "io/shown_text.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr const char* kStyle =
    "body{font:15px/1.5 system-ui,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;"
    "color:#222;background:#fff}\n"
    "h1{font-size:1.5em}h2{font-size:1.15em;margin:1.6em 0 .4em}\n"
    "table{border-collapse:collapse}th,td{text-align:left;vertical-align:top;padding:.2em 1.2em "
    ".2em 0;"
    "border-bottom:1px solid #e4e4e4}\n"
    "th{font-weight:600}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}\n"
    "iframe{width:100%;height:36em;border:1px solid #e4e4e4}\n"
    "img{max-width:100%;border:1px solid #e4e4e4}code,td,pre{overflow-wrap:anywhere}\n"
    ".verdict{padding:.5em .8em;border-left:.4em solid #c77700;background:#fff6e8}\n"
    ".verdict.clean{border-color:#2e7d32;background:#eef7ee}\n"
    "pre{white-space:pre-wrap;margin:.4em 0}.scroll{max-height:40em;overflow:auto}\n";

/// Pictures beyond that would make the page a burden; they are a file of their own anyway.
constexpr std::size_t kPictureLimitBytes = std::size_t{16} << 20;

constexpr std::size_t kHolesShown = 1000;
constexpr std::size_t kReasonsShown = 6;

using Rows = std::vector<std::pair<std::string, std::string>>;

std::string heading(const std::string& text) { return "<h2>" + html_text(text) + "</h2>\n"; }

std::string facts(const std::string& title, const Rows& rows) {
  std::string html = heading(title) + "<table>\n";
  for (const auto& [name, value] : rows)
    html += "<tr><th>" + html_text(name) + "</th><td>" + html_text(value) + "</td></tr>\n";
  return html + "</table>\n";
}

/// The first `texts` cells hold words, the others numbers.
std::string row(const std::vector<std::string>& cells, const char* tag, std::size_t texts = 1) {
  std::string html = "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i)
    html += std::string("<") + tag + (i < texts ? ">" : " class=\"n\">") + html_text(cells[i]) +
            "</" + tag + ">";
  return html + "</tr>\n";
}

std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

std::string box_text(const Box& box) {
  return box.empty() ? "none"
                     : "from " + format_position(box.min) + " to " + format_position(box.max);
}

std::string yes_or_no(bool value) { return value ? "yes" : "no"; }

std::string mesh_table(const MeshFacts& mesh) {
  Rows rows = {{"vertices", format_count(mesh.vertices)},
               {"triangles", format_count(mesh.triangles)},
               {"components", format_count(mesh.components)},
               {"watertight", yes_or_no(mesh.watertight)},
               {"boundary edges", format_count(mesh.boundary_edges)},
               {"boundary loops", format_count(mesh.boundary_loops)},
               {"non-manifold edges", format_count(mesh.nonmanifold_edges)},
               {"non-manifold vertices", format_count(mesh.nonmanifold_vertices)},
               {"inconsistently oriented edges", format_count(mesh.inconsistent_edges)},
               {"degenerate triangles", format_count(mesh.degenerate_triangles)},
               {"duplicate triangles", format_count(mesh.duplicate_triangles)},
               {"vertices without a triangle", format_count(mesh.unreferenced_vertices)},
               {"Euler characteristic", std::to_string(mesh.euler_characteristic)},
               {"area", format_number(mesh.area)},
               {"bounds", box_text(mesh.bounds)},
               {"checksum", mesh.checksum}};
  return facts("Mesh", rows);
}

/// How much of the input is known by its content and not by size and time alone.
std::string trust_text(const std::vector<TrustedFile>& files) {
  std::uint64_t bytes = 0, hashed = 0;
  for (const TrustedFile& file : files) {
    bytes += file.bytes;
    hashed += file.bytes_hashed;
  }
  return format_bytes(hashed) + " of " + format_bytes(bytes) + "; the rest by size and time";
}

/// The text of a coordinate system is long: it unfolds.
std::string coordinate_system_details(const std::string& text) {
  if (text.empty()) return "";
  return "<details><summary>coordinate system</summary><pre>" + html_text(text) +
         "</pre></details>\n";
}

std::string input_table(const RunReport& report) {
  Rows rows = {{"files", joined(report.files, ", ")},
               {"points read", format_count(report.points_read)}};
  for (const auto& [reason, count] : report.points_dropped)
    rows.emplace_back("dropped: " + reason, format_count(count));
  rows.emplace_back("hashed of the files", trust_text(report.trusted));
  rows.emplace_back("points that no triangle uses", format_count(report.points_unused));
  rows.emplace_back("bounds", box_text(report.bounds));
  return facts("Input", rows) + coordinate_system_details(report.coordinate_system);
}

std::string cleaning_table(const RunReport& report) {
  const CleaningFacts& cleaning = report.cleaning;
  Rows rows = {{"spacing of the raw points", format_number(cleaning.spacing)},
               {"thickness of the layers", format_number(cleaning.thickness)}};
  if (!cleaning.reason.empty()) rows.emplace_back("what follows", cleaning.reason);
  if (cleaning.options.outlier_sigma > 0.0)
    rows.emplace_back("outliers beyond", format_number(cleaning.options.outlier_sigma) + " sigma");
  if (cleaning.options.merge_tolerance > 0.0)
    rows.emplace_back("merged within", format_number(cleaning.options.merge_tolerance));
  if (cleaning.options.smooth_radius > 0.0) {
    rows.emplace_back("smoothed within", format_number(cleaning.options.smooth_radius) + ", " +
                                             std::to_string(cleaning.options.smooth_passes) +
                                             " passes");
    if (cleaning.is_local)
      rows.emplace_back("place by place", "radii from " + format_number(cleaning.least_radius) +
                                              " to " + format_number(cleaning.most_radius));
    rows.emplace_back("points moved", format_count(cleaning.points_moved) + ", by " +
                                          format_number(cleaning.mean_move) + " on average");
  }
  if (cleaning.options.thin_to_spacing > 0.0)
    rows.emplace_back("thinned to", format_number(cleaning.options.thin_to_spacing));
  const NormalFacts& normals = report.normals;
  const std::string source = text_of(normals.source);
  rows.emplace_back("normals", normals.orientation == Orientation::kAuto
                                   ? source
                                   : source + ", side by " + text_of(normals.orientation));
  if (normals.patches > 0) {
    rows.emplace_back("patches", format_count(normals.patches));
    rows.emplace_back("contested patches", format_count(normals.contested));
    for (const ContestedFacts& place : normals.contested_places)
      rows.emplace_back("contested near " + format_position(place.center),
                        format_count(place.patches));
    if (normals.interiors > 0)
      rows.emplace_back("components seen from inside", format_count(normals.interiors));
    for (const DoubtfulFacts& part : normals.doubtful)
      rows.emplace_back("a guess near " + format_position(part.center),
                        format_number(std::round(1000.0 * part.area) / 10.0) +
                            " % of the surface: " + part.reason);
    rows.emplace_back("share of votes that agree", format_number(normals.satisfied));
    if (normals.orientation == Orientation::kGround)
      rows.emplace_back("patches of the ground", format_count(normals.ground_patches) + ", " +
                                                     format_count(normals.ground_patches_down) +
                                                     " of them face down");
  }
  return facts("Cleaning and normals", rows);
}

/// What a method of the Voronoi family tells of its points and seams.
void add_voronoi(const RunReport& report, Rows& rows) {
  if (!report.voronoi) return;
  rows.emplace_back("undersampled points", format_count(report.voronoi->undersampled_points));
  if (report.chunks < 2) return;
  rows.emplace_back("points of uncertified Voronoi cells",
                    format_count(report.voronoi->uncertified_points));
  rows.emplace_back("chunks computed with a grown box", format_count(report.voronoi->grown_boxes));
  rows.emplace_back("triangles across chunks", format_count(report.voronoi->seam_triangles));
  rows.emplace_back("contested triangles", format_count(report.voronoi->contested_triangles));
}

std::string work_table(const RunReport& report) {
  std::string radii;
  for (const double radius : report.radii)
    radii += (radii.empty() ? "" : ", ") + format_exact(radius);
  Rows rows = {{"chunks", format_count(report.chunks)},
               {"points of the largest chunk", format_count(report.largest_chunk_points)},
               {"halo width", format_number(report.halo_width)},
               {"ball radii", radii},
               {"why these radii", report.radii_reason},
               {"triangles that lost a conflict", format_count(report.conflicts_lost)}};
  add_voronoi(report, rows);
  return facts("Partition and radii", rows);
}

std::string holes_line(const HoleSummary& holes) {
  std::string line = format_count(holes.loops) + (holes.loops == 1 ? " loop, " : " loops, ") +
                     format_count(holes.filled) + " filled";
  if (holes.filled > 0)
    line += " (" + counted_list(holes.methods, holes.methods.size()) + "; " +
            format_count(holes.points_added) + " points and " +
            format_count(holes.triangles_added) + " triangles added)";
  if (holes.doubtful > 0) line += ", " + format_count(holes.doubtful) + " of them doubtful";
  line += ", " + format_count(holes.open) + " left open";
  if (holes.open > 0) line += " (" + counted_list(holes.reasons, kReasonsShown) + ")";
  return line + ".";
}

std::string tenths(double value) { return format_number(std::round(10.0 * value) / 10.0); }

std::string hundredths(double value) { return format_number(std::round(100.0 * value) / 100.0); }

std::string hole_row(const HoleFacts& hole) {
  const bool solved = hole.sites > 0;
  return row({std::to_string(hole.id), hole.filled ? hole.method : "open", hole.reason,
              format_count(hole.edges), format_number(hole.diameter), format_number(hole.perimeter),
              format_count(hole.chunks.size()), format_count(hole.points_added),
              solved ? format_count(hole.sites) : "", solved ? format_number(hole.residual) : "",
              hole.filled ? tenths(hole.rim_dihedral_deg) : "",
              hole.filled ? hundredths(hole.confidence) : "", format_duration(hole.seconds)},
             "td", 3);
}

/// The page lists the widest holes only; a browser is slow with a hundred thousand rows.
std::string holes_table(const std::vector<HoleFacts>& holes) {
  if (holes.empty()) return "";
  std::string html =
      heading("Holes") + "<p>" + html_text(holes_line(hole_summary(holes))) + "</p>\n";
  if (holes.size() > kHolesShown)
    html += "<p>The " + std::to_string(kHolesShown) + " widest; the JSON report has all.</p>\n";
  html += "<div class=\"scroll\"><table>\n" +
          row({"hole", "method", "why", "edges", "diameter", "perimeter", "chunks", "points added",
               "sites", "residual", "angle at the rim (deg)", "confidence", "time"},
              "th", 3);
  for (const HoleFacts* hole : widest_holes(holes, kHolesShown)) html += hole_row(*hole);
  return html + "</table></div>\n";
}

std::string stage_row(const StageFacts& stage) {
  const double rate = stage.seconds > 0.0 ? static_cast<double>(stage.points) / stage.seconds : 0.0;
  return row({stage.name, format_duration(stage.seconds), format_duration(stage.cpu_seconds),
              stage.points > 0 ? format_rate(rate) : "", format_bytes(stage.bytes_read),
              format_bytes(stage.bytes_written), format_count(stage.chunks),
              format_count(stage.chunks_reused), format_bytes(stage.peak_memory_bytes)},
             "td");
}

std::string stages_table(const RunReport& report) {
  std::string html = heading("Stages") + "<table>\n" +
                     row({"stage", "time", "CPU time", "points/s", "read", "written", "chunks",
                          "of an earlier run", "peak memory"},
                         "th");
  for (const StageFacts& stage : report.stages) html += stage_row(stage);
  return html + "</table>\n";
}

std::string options_table(const Job& job) {
  Rows rows;
  for (const JobKey& key : job_keys())
    rows.emplace_back(key.name(), value_text(key.get(job), key.type));
  return facts("Options", rows);
}

/// Zero stands for an unknown value.
std::string bytes_or_unknown(std::uint64_t bytes) {
  return bytes > 0 ? format_bytes(bytes) : "not known";
}

std::string memory_table(const RunReport& report) {
  return facts("Memory", {{"budget", format_bytes(report.options.partition.memory_bytes)},
                          {"peak, predicted", bytes_or_unknown(report.predicted.peak_memory_bytes)},
                          {"peak, measured", bytes_or_unknown(report.peak_memory_bytes)}});
}

std::string forecast_table(const RunReport& report) {
  const auto time = [](double seconds) {
    return seconds > 0.0 ? format_duration(seconds) : std::string("not known");
  };
  return facts("Disk and time", {{"disk, predicted", bytes_or_unknown(report.predicted.disk_bytes)},
                                 {"disk, measured", bytes_or_unknown(report.measured.disk_bytes)},
                                 {"time, predicted", time(report.predicted.seconds)},
                                 {"time, measured", time(report.measured.seconds)}});
}

std::string machine_table() {
  const MachineFacts machine = machine_facts();
  return facts("Machine", {{"cores", std::to_string(machine.cores)},
                           {"processor", machine.cpu_model},
                           {"memory", format_bytes(machine.memory_bytes)}});
}

std::string notes_list(const std::vector<std::string>& notes) {
  if (notes.empty()) return "";
  std::string html = heading("Notes") + "<ul>\n";
  for (const std::string& note : notes) html += "<li>" + html_text(note) + "</li>\n";
  return html + "</ul>\n";
}

std::string verdict_line(const RunReport& report) {
  const Verdict verdict = verdict_of(report);
  return std::string("<p class=\"verdict") + (verdict.is_clean ? " clean" : "") + "\">" +
         html_text(verdict.text) + "</p>\n";
}

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    unsigned group = 0;
    for (std::size_t i = at; i < at + 3; ++i)
      group = group << 8 | (i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0u);
    for (std::size_t digit = 0; digit < 4; ++digit)
      text += at + digit <= bytes.size() ? kDigits[group >> (18 - 6 * digit) & 63] : '=';
  }
  return text;
}

std::string picture(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (path.empty() || path == "-" || !file) return "";
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.empty() || bytes.size() > kPictureLimitBytes) return "";
  return "<p><img alt=\"The mesh\" src=\"data:image/png;base64," + base64(bytes) + "\"></p>\n";
}

/// A page in a frame, so that its style and its names stay apart from the report's.
std::string viewer_frame(const std::string& viewer) {
  if (viewer.empty()) return "";
  std::string text;
  text.reserve(viewer.size() + viewer.size() / 16);
  for (const char c : viewer) {
    if (c == '&')
      text += "&amp;";
    else if (c == '"')
      text += "&quot;";
    else
      text += c;
  }
  return heading("The mesh to turn") + "<iframe title=\"The mesh\" srcdoc=\"" + text +
         "\"></iframe>\n";
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string html;
  for (const char c : shown(text)) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      case '\'':
        html += "&#39;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

std::string report_html(const RunReport& report, const std::string& viewer) {
  const std::string title =
      report.options.output.mesh.empty()
          ? "Surface reconstruction"
          : std::filesystem::path(report.options.output.mesh).filename().string();
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>" +
         html_text(title) + "</title>\n<style>\n" + kStyle + "</style>\n</head>\n<body>\n<h1>" +
         html_text(title) + "</h1>\n" + verdict_line(report) + "<p>orbweave " +
         html_text(report.version) + ": <code>" + html_text(joined(report.command, " ")) +
         "</code></p>\n" + picture(report.options.output.picture) + viewer_frame(viewer) +
         mesh_table(report.mesh) + input_table(report) + cleaning_table(report) +
         work_table(report) + holes_table(report.holes) + stages_table(report) +
         memory_table(report) + forecast_table(report) + machine_table() +
         notes_list(report.notes) + options_table(report.options) + "</body>\n</html>\n";
}

}  // namespace orbweave
