#include "io/report.h"

#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/job_keys.h"
#include "io/machine.h"
#include "io/report_html.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

/// Paths need not be UTF-8; JSON must.
std::string dumped(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json bounds_json(const Box& box) {
  if (box.empty()) return nullptr;
  return {{"min", {box.min.x, box.min.y, box.min.z}}, {"max", {box.max.x, box.max.y, box.max.z}}};
}

Json options_json(const Job& job) {
  Json options = Json::object();
  for (const JobKey& key : job_keys())
    options[key.section][key.key] =
        std::visit([](const auto& value) { return Json(value); }, key.get(job));
  return options;
}

Json input_json(const RunReport& report) {
  Json dropped = Json::object();
  for (const auto& [reason, count] : report.points_dropped) dropped[reason] = count;
  return {{"files", report.files},
          {"points_read", report.points_read},
          {"points_dropped", dropped},
          {"bounds", bounds_json(report.bounds)}};
}

Json mesh_json(const MeshFacts& facts) {
  return {{"vertices", facts.vertices},
          {"triangles", facts.triangles},
          {"components", facts.components},
          {"boundary_edges", facts.boundary_edges},
          {"boundary_loops", facts.boundary_loops},
          {"nonmanifold_edges", facts.nonmanifold_edges},
          {"nonmanifold_vertices", facts.nonmanifold_vertices},
          {"inconsistent_edges", facts.inconsistent_edges},
          {"degenerate_triangles", facts.degenerate_triangles},
          {"duplicate_triangles", facts.duplicate_triangles},
          {"unreferenced_vertices", facts.unreferenced_vertices},
          {"euler_characteristic", facts.euler_characteristic},
          {"area", facts.area},
          {"watertight", facts.watertight},
          {"checksum", facts.checksum},
          {"bounds", bounds_json(facts.bounds)}};
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
          {"chunks_reused", stage.chunks_reused}};
}

Json stages_json(const std::vector<StageFacts>& stages) {
  Json list = Json::array();
  for (const StageFacts& stage : stages) list.push_back(stage_json(stage));
  return list;
}

Json machine_json() {
  const MachineFacts machine = machine_facts();
  return {{"cores", machine.cores},
          {"cpu_model", machine.cpu_model},
          {"memory_bytes", machine.memory_bytes}};
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
  json["options"] = options_json(report.options);
  json["input"] = input_json(report);
  json["partition"] = {{"chunks", report.chunks},
                       {"halo_width", report.halo_width},
                       {"largest_chunk_points", report.largest_chunk_points}};
  json["radii"] = {{"values", report.radii}, {"reason", report.radii_reason}};
  json["points_unused"] = report.points_unused;
  json["conflicts_lost"] = report.conflicts_lost;
  json["mesh"] = mesh_json(report.mesh);
  json["holes"] = Json::array();
  json["stages"] = stages_json(report.stages);
  json["peak_memory_bytes"] = report.peak_memory_bytes;
  json["machine"] = machine_json();
  json["notes"] = report.notes;
  return dumped(json);
}

std::string mesh_facts_json(const MeshFacts& facts) {
  Json json = {{"kind", "mesh"}};
  json.update(mesh_json(facts));
  return dumped(json);
}

void write_report(const std::filesystem::path& path, const RunReport& report) {
  std::filesystem::path page = path;
  page.replace_extension(".html");
  write_text(path, report_json(report));
  std::error_code ignored;
  const bool is_device =
      std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored);
  if (page != path && !is_device) write_text(page, report_html(report));
}

}  // namespace orbweave
