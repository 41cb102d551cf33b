#include "engine/cli/cloud_listing.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "engine/cli/json_text.h"
#include "engine/cli/output.h"
#include "io/shown_text.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json json_or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

Json vector_json(Vec3 v) { return {v.x, v.y, v.z}; }

Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

Json attributes_json(const CloudFacts& facts) {
  Json attributes = Json::array();
  for (std::size_t i = 0; i < facts.attributes.size(); ++i) {
    const std::optional<ValueRange>& range = facts.values.ranges[i];
    attributes.push_back({{"name", facts.attributes[i].name},
                          {"type", name_of(facts.attributes[i].type)},
                          {"min", range ? Json(range->min) : Json()},
                          {"max", range ? Json(range->max) : Json()}});
  }
  return attributes;
}

Json classes_json(const AttributeFacts& values) {
  if (!values.has_classes) return {};
  Json classes = Json::array();
  for (std::size_t number = 0; number < values.classes.size(); ++number)
    if (values.classes[number] != 0)
      classes.push_back({{"class", number},
                         {"name", text_or_null(plain_name_of_class(static_cast<int>(number)))},
                         {"points", values.classes[number]}});
  return classes;
}

Json returns_json(const AttributeFacts& values) {
  if (!values.returns) return {};
  return {{"first", values.returns->first},
          {"last", values.returns->last},
          {"only", values.returns->only},
          {"most", values.returns->most}};
}

Json pose_json(const RigidMotion& pose) {
  return {{"rotation",
           {vector_json(pose.rows[0]), vector_json(pose.rows[1]), vector_json(pose.rows[2])}},
          {"translation", vector_json(pose.translation)}};
}

Json scans_json(const FileFacts& file) {
  Json scans = Json::array();
  for (const ScanFacts& scan : file.scans)
    scans.push_back({{"name", text_or_null(scan.name)},
                     {"sensor", text_or_null(scan.sensor)},
                     {"points", scan.points},
                     {"pose", scan.pose ? pose_json(*scan.pose) : Json()},
                     {"scanner", scan.scanner ? vector_json(scan.scanner->vector) : Json()}});
  return scans;
}

std::string range_text(const std::optional<ValueRange>& range) {
  if (!range) return "no value";
  return format_number(range->min) + " to " + format_number(range->max);
}

void add_attributes(const CloudFacts& facts, Facts& lines) {
  if (facts.attributes.empty()) lines.emplace_back("attributes", "none");
  for (std::size_t i = 0; i < facts.attributes.size(); ++i)
    lines.emplace_back(i == 0 ? "attributes" : "", shown(facts.attributes[i].name) + " (" +
                                                       name_of(facts.attributes[i].type) +
                                                       "): " + range_text(facts.values.ranges[i]));
}

void add_classes(const AttributeFacts& values, Facts& lines) {
  constexpr int kShown = 20;
  const char* name = "classes";
  int met = 0;
  for (std::size_t number = 0; number < values.classes.size(); ++number) {
    if (values.classes[number] == 0 || ++met > kShown) continue;
    const std::string plain = plain_name_of_class(static_cast<int>(number));
    lines.emplace_back(name, std::to_string(number) + (plain.empty() ? "" : " " + plain) + ": " +
                                 format_count(values.classes[number]));
    name = "";
  }
  if (met > kShown)
    lines.emplace_back(name, "and " + std::to_string(met - kShown) + " more; --json lists all");
  if (values.without_class > 0)
    lines.emplace_back(name, "no class from 0 to 255: " + format_count(values.without_class));
}

void add_returns(const AttributeFacts& values, Facts& lines) {
  if (!values.returns) return;
  const ReturnFacts& returns = *values.returns;
  lines.emplace_back("returns", "first " + format_count(returns.first) + ", last " +
                                    format_count(returns.last) + ", only " +
                                    format_count(returns.only) + "; up to " +
                                    format_count(returns.most) + " of a pulse");
}

std::string place_text(Vec3 p) {
  return format_number(p.x) + " " + format_number(p.y) + " " + format_number(p.z);
}

/// How far a pose turns, in degrees. The trace is 1 + 2 cos, times the scale of the matrix.
std::string turn_text(const RigidMotion& pose) {
  const double scale = norm(pose.rows[0]);
  const double trace = pose.rows[0].x + pose.rows[1].y + pose.rows[2].z;
  const double cosine = std::clamp((trace / scale - 1.0) / 2.0, -1.0, 1.0);
  constexpr double kDegreesPerRadian = 57.29577951308232;
  const double degrees = std::acos(cosine) * kDegreesPerRadian;
  return format_number(std::round(degrees * 1000.0) / 1000.0);
}

/// A table behind an empty line; empty where there are no scans.
std::string scans_text(const std::vector<ScanFacts>& scans) {
  constexpr std::size_t kShown = 16;
  if (scans.empty()) return "";
  std::vector<std::vector<std::string>> rows = {
      {"scan", "points", "moved by", "turned by", "scanner at"}};
  for (std::size_t i = 0; i < std::min(scans.size(), kShown); ++i) {
    const ScanFacts& scan = scans[i];
    const std::string name = std::to_string(i + 1) + (scan.name.empty() ? "" : " " + scan.name) +
                             (scan.sensor.empty() ? "" : " (" + scan.sensor + ")");
    rows.push_back({shown(name), format_count(scan.points),
                    scan.pose ? place_text(scan.pose->translation) : "no pose",
                    scan.pose ? turn_text(*scan.pose) : "",
                    scan.scanner ? place_text(scan.scanner->vector) : "unknown"});
  }
  std::string text = "\n" + table(rows);
  if (scans.size() > kShown)
    text += "and " + format_count(scans.size() - kShown) + " more; --json lists all\n";
  return text;
}

/// Bounds in the header that the points contradict.
bool declares_wrong_bounds(const CloudFacts& facts) {
  const auto& declared = facts.file.declared_bounds;
  if (!declared || facts.bounds.empty()) return false;
  const double room = 1e-6 * facts.bounds.largest_extent() + 1e-2;
  return declared->empty() || !declared->grown(room).contains(facts.bounds.min) ||
         !declared->grown(room).contains(facts.bounds.max);
}

void add_doubts(const CloudFacts& facts, Facts& lines) {
  if (facts.duplicates.value_or(0) > 0)
    lines.emplace_back("duplicates", format_count(*facts.duplicates));
  if (facts.not_finite > 0) lines.emplace_back("not finite", format_count(facts.not_finite));
  if (facts.zero_normals > 0) lines.emplace_back("zero normals", format_count(facts.zero_normals));
  if (facts.normals_not_finite > 0)
    lines.emplace_back("normals not finite", format_count(facts.normals_not_finite));
  if (!facts.doubt.empty()) lines.emplace_back("in doubt", facts.doubt);
  const char* name = "left out";
  for (const auto& [reason, count] : facts.left_out) {
    lines.emplace_back(name, format_count(count) + " dropped: " + reason);
    name = "";
  }
  add_not_read(not_read(facts.file), lines);
  if (declares_wrong_bounds(facts))
    lines.emplace_back("header", "wrong bounds: " + show_box(*facts.file.declared_bounds));
}

}  // namespace

std::string format_text(const FileFacts& file) {
  std::string text = file.format.empty() ? "unknown" : file.format;
  if (!file.version.empty()) text += " " + file.version;
  if (!file.encoding.empty()) text += " " + file.encoding;
  if (file.point_format) text += ", point format " + std::to_string(*file.point_format);
  if (!file.scans.empty()) text += ", " + counted(file.scans.size(), "scan", "scans");
  return text;
}

std::string system_text(const std::string& coordinate_system) {
  if (coordinate_system.empty()) return "unknown";
  const std::size_t open = coordinate_system.find('"');
  const std::size_t close =
      open == std::string::npos ? open : coordinate_system.find('"', open + 1);
  const bool is_wkt = coordinate_system.find('[') < open && close != std::string::npos;
  return shown(is_wkt ? coordinate_system.substr(open + 1, close - open - 1) : coordinate_system);
}

void add_not_read(std::span<const std::string> not_read, Facts& lines) {
  const char* name = "not read";
  for (const std::string& what : not_read) {
    lines.emplace_back(name, shown(what));
    name = "";
  }
}

Json cloud_json(const CloudFacts& facts) {
  const FileFacts& file = facts.file;
  return {{"kind", "cloud"},
          {"points", facts.points},
          {"bounds", box_json(facts.bounds)},
          {"normals", facts.has_normals},
          {"position_type", name_of(facts.position_type)},
          {"attributes", attributes_json(facts)},
          {"spacing", json_or_null(facts.spacing)},
          {"spacing_of_six", json_or_null(facts.spacing_of_six)},
          {"duplicates", json_or_null(facts.duplicates)},
          {"not_finite", facts.not_finite},
          {"coordinate_step", facts.coordinate_step > 0.0 ? Json(facts.coordinate_step) : Json()},
          {"common_step", facts.common_step > 0.0 ? Json(facts.common_step) : Json()},
          {"doubt", text_or_null(facts.doubt)},
          {"zero_normals", facts.zero_normals},
          {"normals_not_finite", facts.normals_not_finite},
          {"format", text_or_null(file.format)},
          {"version", text_or_null(file.version)},
          {"encoding", text_or_null(file.encoding)},
          {"point_format", json_or_null(file.point_format)},
          {"software", text_or_null(file.software)},
          {"coordinate_system", text_or_null(facts.coordinate_system)},
          {"meters_per_unit", facts.meters_per_unit ? vector_json(*facts.meters_per_unit) : Json()},
          {"declared_bounds", file.declared_bounds ? box_json(*file.declared_bounds) : Json()},
          {"classes", classes_json(facts.values)},
          {"returns", returns_json(facts.values)},
          {"scans", scans_json(file)},
          {"left_out", facts.left_out},
          {"not_read", not_read(file)}};
}

std::string cloud_text(const CloudFacts& facts) {
  Facts lines = {{"kind", "cloud"},
                 {"format", shown(format_text(facts.file))},
                 {"points", format_count(facts.points)},
                 {"bounds", show_box(facts.bounds)},
                 {"system", system_text(facts.coordinate_system)},
                 {"coordinates", name_of(facts.position_type)},
                 {"normals", facts.has_normals ? "yes" : "no"},
                 {"spacing", facts.spacing ? format_number(*facts.spacing) : "unknown"}};
  add_attributes(facts, lines);
  add_classes(facts.values, lines);
  add_returns(facts.values, lines);
  add_doubts(facts, lines);
  return facts_table(lines) + scans_text(facts.file.scans);
}

}  // namespace orbweave
