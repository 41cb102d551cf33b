#include "engine/view/view_page.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string_view>

#include "engine/view/viewer_template.h"
#include "io/bounds.h"
#include "io/meshes/vertex_colors.h"
#include "io/text/json_dump.h"
#include "io/vertex_values.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kSteps = 65535.0;

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < count ? static_cast<std::uint32_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k)
      text += k <= count ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

template <class T>
void append(std::vector<std::byte>& bytes, const T& value) {
  const auto from = std::as_bytes(std::span(&value, 1));
  bytes.insert(bytes.end(), from.begin(), from.end());
}

/// Steps of a value between the ends of its range; the last one: not known.
std::uint8_t value_step(float value, const ShownRange& range) {
  constexpr std::uint8_t kUnknown = 255;
  constexpr double kMost = 254.0;
  if (!(value >= 0.0F)) return kUnknown;
  const double width = range.high > range.low ? range.high - range.low : 1.0;
  return static_cast<std::uint8_t>(
      std::lround(kMost * std::clamp((value - range.low) / width, 0.0, 1.0)));
}

void append_values(std::vector<std::byte>& bytes, const PointCloud& vertices,
                   std::span<const ShownRange> ranges) {
  const std::size_t row_bytes = vertices.schema.attribute_bytes();
  for (const ShownRange& range : ranges)
    for (const VertexValue& value : vertex_values(vertices.schema)) {
      if (value.name != range.name) continue;
      for (std::size_t i = 0; i < vertices.size(); ++i)
        append(bytes,
               value_step(value_at(value, vertices.attributes.data() + i * row_bytes), range));
    }
}

std::vector<ShownRange> ranges_of(const PointCloud& vertices) {
  ShownRanges ranges(vertices.schema);
  ranges.add(vertices.attributes);
  return ranges.ranges();
}

/// The number of a place on an axis; the nearest one for what lies beyond the surface.
std::uint16_t step_of(double local, double step) {
  const double steps = local / step;
  return std::isnan(steps)
             ? std::uint16_t{0}
             : static_cast<std::uint16_t>(std::lround(std::clamp(steps, 0.0, kSteps)));
}

/// Corners, then places in steps, then colours.
std::vector<std::byte> page_data(const TriangleMesh& mesh, const Box& bounds, double step) {
  const std::vector<Vec3>& positions = mesh.vertices.positions;
  std::vector<std::byte> bytes;
  for (const Triangle& t : mesh.triangles) {
    // What has a corner nowhere is not drawn, and keeps its number.
    const bool has_place =
        std::ranges::all_of(t, [&](std::uint32_t corner) { return is_finite(positions[corner]); });
    append(bytes, has_place ? t : Triangle{t[0], t[0], t[0]});
  }
  for (const Vec3& position : positions) {
    const Vec3 local = position - bounds.min;
    for (int axis = 0; axis < 3; ++axis) append(bytes, step_of(local[axis], step));
  }
  const VertexColors colors(mesh.vertices.schema);
  if (!colors.all_are_there()) return bytes;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    for (const VertexColors::Channel& channel : colors.of(mesh.vertices, i))
      append(bytes,
             static_cast<std::uint8_t>(channel.most == 255 ? channel.value : channel.value / 257));
  return bytes;
}

/// First triangle, how many, hole and, where it is known, confidence.
Json patch_runs(std::span<const std::int32_t> hole, std::span<const float> confidence) {
  Json runs = Json::array();
  for (std::size_t first = 0; first < hole.size();) {
    std::size_t end = first + 1;
    while (end < hole.size() && hole[end] == hole[first]) ++end;
    if (hole[first] > 0) {
      runs.push_back({first, end - first, hole[first]});
      if (!confidence.empty()) runs.back().push_back(confidence[first]);
    }
    first = end;
  }
  return runs;
}

/// A script's text ends nowhere before its end.
std::string for_script(std::string text) {
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;)
    text.replace(at, 1, "\\u003c");
  return text;
}

void put_in(std::string& page, std::string_view place, const std::string& text) {
  const std::size_t at = page.find(place);
  if (at == std::string::npos)
    throw std::logic_error("the viewer's page has no place for its data");
  page.replace(at, place.size(), text);
}

/// What is put in last may hold any words.
std::string page_of(const Json& meta, const std::string& scripts) {
  std::string text(kViewerTemplate);
  put_in(text, "ORBWEAVE_SCRIPTS", scripts);
  put_in(text, "ORBWEAVE_META", for_script(json_dump(meta)));
  return text;
}

}  // namespace

std::uint64_t view_page_bytes(std::uint64_t vertices, std::uint64_t triangles,
                              const PointSchema& schema) {
  const bool has_colors = VertexColors(schema).all_are_there();
  const std::uint64_t of_vertex = (has_colors ? 9 : 6) + vertex_values(schema).size();
  const std::uint64_t data = triangles * 12 + vertices * of_vertex;
  return kViewerTemplate.size() + kViewerScript.size() + kViewerMeshScript.size() +
         (data + 2) / 3 * 4;
}

std::string view_page(const TriangleMesh& mesh, const ViewPage& page) {
  Box bounds = bounds_of_surface(mesh.vertices.positions, mesh.triangles);
  if (bounds.empty()) bounds = mesh.vertices.bounds();
  const Vec3 extent = bounds.extent();
  const double step = bounds.largest_extent() > 0.0 ? bounds.largest_extent() / kSteps : 1.0;
  Json meta = {{"name", page.name},
               {"vertices", mesh.vertices.size()},
               {"triangles", mesh.triangles.size()},
               {"min", {bounds.min.x, bounds.min.y, bounds.min.z}},
               {"extent", {extent.x, extent.y, extent.z}},
               {"step", step},
               {"up", page.up_axis},
               {"colors", VertexColors(mesh.vertices.schema).all_are_there()},
               {"patches", patch_runs(mesh.hole, page.confidence)},
               {"facts", page.facts}};
  if (!page.report.empty()) meta["report"] = Json::parse(page.report);
  const std::vector<ShownRange> ranges = ranges_of(mesh.vertices);
  meta["values"] = Json::array();
  for (const ShownRange& range : ranges) meta["values"].push_back(range.name);
  std::vector<std::byte> data = page_data(mesh, bounds, step);
  append_values(data, mesh.vertices, ranges);
  return page_of(meta, "<script id=\"data\" type=\"text/plain\">" + base64(data) +
                           "</script>\n<script>\n" + std::string(kViewerScript) +
                           std::string(kViewerMeshScript) + "</script>");
}

std::vector<NamedText> view_folder_files(const std::string& name, const std::string& report) {
  const Json meta = {{"name", name}, {"report", !report.empty()}};
  std::vector<NamedText> files = {
      {kFolderPage, page_of(meta, "<script src=\"" + std::string(kFolderScript) + "\"></script>")},
      {kFolderScript, std::string(kViewerScript) + std::string(kViewerTilesScript)}};
  if (!report.empty()) files.push_back({"report.json", report});
  return files;
}

}  // namespace orbweave
