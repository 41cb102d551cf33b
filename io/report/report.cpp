#include "io/report/report.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string_view>

#include "io/job/job_keys.h"
#include "io/points/length_units.h"
#include "io/report/machine.h"
#include "io/report/reasons.h"
#include "io/report/report_html.h"
#include "io/report/verdict.h"
#include "io/system/atomic_file.h"
#include "io/text/json_dump.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

/// Stands for the list of holes until the text is made: a list of a million of them would take
/// kilobytes each as a document.
constexpr const char* kHolesKey = "\"holes\": null";

std::string dumped(const Json& json) { return json_dump(json, 2) + "\n"; }

Json bounds_json(const Box& box) {
  if (box.empty()) return nullptr;
  return {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}};
}

/// Infinity becomes null, as JSON has it.
Json options_json(const Job& job, std::initializer_list<std::string_view> sections = {}) {
  Json options = Json::object();
  for (const JobKey& key : job_keys())
    if (sections.size() == 0 || std::ranges::find(sections, key.section) != sections.end())
      options[key.section][key.key] =
          std::visit([](const auto& value) { return Json(value); }, key.get(job));
  return options;
}

/// In units of the scans.
Json extent_json(const RunReport& report) {
  if (report.bounds.empty()) return nullptr;
  const Vec3 extent = report.bounds.extent();
  return {extent.x, extent.y, extent.z};
}

/// Null where the unit is not known.
Json extent_meters_json(const RunReport& report) {
  const std::optional<Vec3> unit =
      meters_per_unit(report.options.input.units_per_meter, report.meters_per_unit);
  if (report.bounds.empty() || !unit) return nullptr;
  const Vec3 extent = report.bounds.extent();
  return {extent.x * unit->x, extent.y * unit->y, extent.z * unit->z};
}

Json trusted_json(const std::vector<TrustedFile>& files) {
  Json list = Json::array();
  for (const TrustedFile& file : files)
    list.push_back({{"file", file.file},
                    {"bytes", file.bytes},
                    {"modified", file.modified},
                    {"bytes_hashed", file.bytes_hashed}});
  return list;
}

Json input_json(const RunReport& report) {
  Json dropped = Json::object();
  for (const auto& [reason, count] : report.points_dropped) dropped[reason] = count;
  return {{"files", report.files},
          {"points_read", report.points_read},
          {"points_dropped", dropped},
          {"bounds", bounds_json(report.bounds)},
          {"extent", extent_json(report)},
          {"extent_meters", extent_meters_json(report)},
          {"trusted", trusted_json(report.trusted)}};
}

Json count_or_null(const std::optional<std::uint64_t>& count) {
  return count ? Json(*count) : Json();
}

Json mesh_json(const MeshFacts& facts) {
  return {{"vertices", facts.vertices},
          {"triangles", facts.triangles},
          {"components", facts.components},
          {"boundary_edges", facts.boundary_edges},
          {"boundary_loops", facts.boundary_loops},
          {"nonmanifold_edges", facts.nonmanifold_edges},
          {"nonmanifold_vertices", facts.nonmanifold_vertices},
          {"pinches", count_or_null(facts.pinches)},
          {"mended_triangles", facts.mended_triangles},
          {"inconsistent_edges", facts.inconsistent_edges},
          {"degenerate_triangles", facts.degenerate_triangles},
          {"duplicate_triangles", facts.duplicate_triangles},
          {"unreferenced_vertices", facts.unreferenced_vertices},
          {"crossing_pairs", count_or_null(facts.crossing_pairs)},
          {"patch_crossing_pairs", count_or_null(facts.patch_crossing_pairs)},
          {"euler_characteristic", facts.euler_characteristic},
          {"area", facts.area},
          {"patch_area", facts.patch_area},
          {"watertight", facts.watertight},
          {"checksum", facts.checksum},
          {"bounds", bounds_json(facts.bounds)}};
}

/// Null: coordinates of the file are those of the scans.
Json origin_json(Vec3 origin) {
  if (origin == Vec3{}) return nullptr;
  return {origin.x, origin.y, origin.z};
}

Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

Json hole_json(const HoleFacts& hole) {
  return {{"id", hole.id},
          {"first_vertex", hole.first_vertex},
          {"edges", hole.edges},
          {"perimeter", hole.perimeter},
          {"diameter", hole.diameter},
          {"center", {hole.center.x, hole.center.y, hole.center.z}},
          {"chunks", hole.chunks},
          {"filled", hole.filled},
          {"method", text_or_null(hole.method)},
          {"reason", text_or_null(hole.reason)},
          {"joined_to", hole.joined_to},
          {"sites", hole.sites},
          {"points_added", hole.points_added},
          {"triangles_added", hole.triangles_added},
          {"area", hole.area},
          {"open_edges", hole.open_edges},
          {"residual", hole.residual},
          {"condition", hole.condition},
          {"rim_dihedral_deg", hole.rim_dihedral_deg},
          {"rim_mean_deg", hole.rim_mean_deg},
          {"confidence", hole.filled ? Json(hole.confidence) : Json()},
          {"seconds", hole.seconds}};
}

/// A line per hole, indented as members of a member of the document.
void append_hole_lines(std::span<const HoleFacts> holes, const std::string& indent,
                       std::string& text) {
  constexpr std::size_t kUsualLine = 512;  // bytes; more would be copied when it grows
  text.reserve(text.size() + kUsualLine * holes.size());
  text += "[";
  // A few blocks at a time, so that most lines are held once.
  constexpr std::size_t kBlock = 256, kBlocks = 64;
  std::vector<std::string> blocks(kBlocks);
  for (std::size_t first = 0; first < holes.size(); first += kBlock * kBlocks) {
    const auto some = holes.subspan(first, std::min(kBlock * kBlocks, holes.size() - first));
    tbb::parallel_for(std::size_t{0}, kBlocks, [&](std::size_t b) {
      blocks[b].clear();
      for (std::size_t i = b * kBlock; i < std::min((b + 1) * kBlock, some.size()); ++i) {
        blocks[b] += (first + i == 0 ? "\n  " : ",\n  ") + indent;
        blocks[b] += json_dump(hole_json(some[i]));
      }
    });
    for (const std::string& block : blocks) text += block;
  }
  text += holes.empty() ? "]" : "\n" + indent + "]";
}

/// The document's text with the holes where its member "holes" is null. No text inside the
/// document looks like that member: its quotes would be escaped.
std::string dumped_with_holes(const Json& json, std::span<const HoleFacts> holes) {
  std::string text = dumped(json);
  const std::string member(kHolesKey);
  const std::size_t at = text.find("\n  " + member) + 3;
  const std::string rest = text.substr(at + member.size());
  text.resize(at);
  text += "\"holes\": ";
  append_hole_lines(holes, "  ", text);  // in place: of a million holes it is hundreds of megabytes
  return text += rest;
}

Json stage_json(const StageFacts& stage) {
  const double rate = stage.seconds > 0.0 ? static_cast<double>(stage.points) / stage.seconds : 0.0;
  return {{"name", stage.name},
          {"seconds", stage.seconds},
          {"cpu_seconds", stage.cpu_seconds},
          {"points", stage.points},
          {"points_per_second", rate},
          {"bytes_read", stage.bytes_read},
          {"bytes_written", stage.bytes_written},
          {"chunks", stage.chunks},
          {"chunks_reused", stage.chunks_reused},
          {"peak_memory_bytes", stage.peak_memory_bytes},
          {"chunk_seconds", stage.chunk_seconds},
          {"chunk_cpu_seconds", stage.chunk_cpu_seconds},
          {"counter_calls", stage.counter_calls}};
}

Json stages_json(const std::vector<StageFacts>& stages) {
  Json list = Json::array();
  for (const StageFacts& stage : stages) list.push_back(stage_json(stage));
  return list;
}

/// What all stages of all processes moved.
Json traffic_json(const RunReport& report) {
  std::uint64_t read = 0, written = 0, calls = 0;
  for (const StageFacts& stage : report.stages) {
    read += stage.bytes_read;
    written += stage.bytes_written;
    calls += stage.counter_calls;
  }
  const auto points = static_cast<double>(std::max<std::uint64_t>(report.points_read, 1));
  return {{"bytes_read", read},
          {"bytes_written", written},
          {"bytes_per_point", static_cast<double>(read + written) / points},
          {"counter_calls", calls}};
}

Json resources_json(const ResourceFacts& facts) {
  return {{"peak_memory_bytes", facts.peak_memory_bytes},
          {"disk_bytes", facts.disk_bytes},
          {"seconds", facts.seconds}};
}

Json machine_json() {
  const MachineFacts machine = machine_facts();
  return {{"cores", machine.cores},
          {"cpu_model", machine.cpu_model},
          {"memory_bytes", machine.memory_bytes}};
}

Json cleaning_json(const CleaningFacts& facts) {
  return {{"thickness", facts.thickness},
          {"spacing", facts.spacing},
          {"outlier_sigma", facts.options.outlier_sigma},
          {"merge_tolerance", facts.options.merge_tolerance},
          {"smooth_radius", facts.options.smooth_radius},
          {"smooth_passes", facts.options.smooth_radius > 0.0 ? facts.options.smooth_passes : 0},
          {"thin_to_spacing", facts.options.thin_to_spacing},
          {"reason", text_or_null(facts.reason)},
          {"cluster_points", facts.options.cluster_points.value_or(0)},
          {"min_surfaceness", facts.options.min_surfaceness},
          {"least_radius", facts.least_radius},
          {"most_radius", facts.most_radius},
          {"untouched_share", facts.untouched_share},
          {"points_moved", facts.points_moved},
          {"mean_move", facts.mean_move}};
}

Json normals_json(const NormalFacts& facts) {
  Json places = Json::array();
  for (const ContestedFacts& place : facts.contested_places)
    places.push_back(
        {{"center", {place.center.x, place.center.y, place.center.z}}, {"patches", place.patches}});
  Json doubtful = Json::array();
  for (const DoubtfulFacts& part : facts.doubtful)
    doubtful.push_back({{"center", {part.center.x, part.center.y, part.center.z}},
                        {"area", part.area},
                        {"reason", part.reason}});
  return {{"source", text_of(facts.source)},
          {"orientation", text_or_null(text_of(facts.orientation))},
          {"neighbors", facts.neighbors},
          {"max_radius", facts.max_radius},
          {"patches", facts.patches},
          {"components", facts.components},
          {"contested_patches", facts.contested},
          {"contested_places", places},
          {"votes_satisfied", facts.satisfied},
          {"ground_patches", facts.ground_patches},
          {"ground_patches_down", facts.ground_patches_down},
          {"interior_components", facts.interiors},
          {"contested_area", facts.contested_area},
          {"doubtful_area", facts.doubtful_area},
          {"doubtful_parts", doubtful}};
}

Json voronoi_json(const std::optional<VoronoiFacts>& facts) {
  if (!facts) return nullptr;
  return {{"undersampled_points", facts->undersampled_points},
          {"uncertified_points", facts->uncertified_points},
          {"grown_boxes", facts->grown_boxes},
          {"seam_triangles", facts->seam_triangles},
          {"contested_triangles", facts->contested_triangles}};
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace

std::string report_json(const RunReport& report) {
  Json json;
  json["version"] = report.version;
  json["command"] = report.command;
  json["verdict"] = verdict_of(report).text;
  json["options"] = options_json(report.options);
  json["input"] = input_json(report);
  json["coordinate_system"] = text_or_null(report.coordinate_system);
  json["cleaning"] = cleaning_json(report.cleaning);
  json["normals"] = normals_json(report.normals);
  json["partition"] = {{"chunks", report.chunks},
                       {"halo_width", report.halo_width},
                       {"largest_chunk_points", report.largest_chunk_points}};
  json["radii"] = {{"values", report.radii}, {"reason", report.radii_reason}};
  json["points_unused"] = report.points_unused;
  json["pieces_removed"] = report.pieces_removed;
  json["triangles_removed"] = report.triangles_removed;
  json["conflicts_lost"] = report.conflicts_lost;
  json["voronoi"] = voronoi_json(report.voronoi);
  json["origin"] = origin_json(report.origin);
  json["mesh"] = mesh_json(report.mesh);
  json["holes"] = nullptr;
  json["stages"] = stages_json(report.stages);
  json["traffic"] = traffic_json(report);
  json["peak_memory_bytes"] = report.peak_memory_bytes;
  json["predicted"] = resources_json(report.predicted);
  json["measured"] = resources_json(report.measured);
  json["ranks"] = report.ranks;
  json["machine"] = machine_json();
  json["notes"] = report.notes;
  json["warnings"] = report.warnings;
  return dumped_with_holes(json, report.holes);
}

std::string mesh_facts_json(const MeshFacts& facts) {
  Json json = {{"kind", "mesh"}};
  json.update(mesh_json(facts));
  return dumped(json);
}

std::string holes_json(std::span<const HoleFacts> holes) {
  std::string text;
  append_hole_lines(holes, "", text);
  return text += "\n";
}

std::string fill_report_json(const FillReport& report) {
  Json dropped = Json::object();
  for (const auto& [reason, count] : report.triangles_dropped) dropped[reason] = count;
  Json json;
  json["version"] = report.version;
  json["command"] = report.command;
  json["options"] = options_json(report.options, {"fill", "output", "run"});
  json["input"] = {{"file", report.file}, {"triangles_dropped", dropped}};
  json["mesh_before"] = mesh_json(report.before);
  json["origin"] = origin_json(report.origin);
  json["mesh"] = mesh_json(report.after);
  json["pieces_removed"] = report.pieces_removed;
  json["triangles_removed"] = report.triangles_removed;
  json["holes"] = nullptr;
  json["seconds"] = report.seconds;
  json["peak_memory_bytes"] = peak_memory_bytes();
  json["machine"] = machine_json();
  return dumped_with_holes(json, report.holes);
}

std::filesystem::path report_page(const std::filesystem::path& report) {
  std::error_code ignored;
  const auto status = std::filesystem::status(report, ignored);
  if (report.empty() || (std::filesystem::exists(status) && std::filesystem::is_other(status)))
    return {};
  std::filesystem::path page = report;
  page.replace_extension(".html");
  return page == report ? std::filesystem::path() : page;
}

void write_report(const std::filesystem::path& path, const RunReport& report,
                  const std::string& viewer) {
  const std::filesystem::path page = report_page(path);
  write_text(path, report_json(report));
  if (!page.empty()) write_text(page, report_html(report, viewer));
}

void write_fill_report(const std::filesystem::path& path, const FillReport& report) {
  write_text(path, fill_report_json(report));
}

}  // namespace orbweave
