#include "engine/levels/tileset_json.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/text/json_dump.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A box as the document has it: a middle and half a side along each axis.
struct MiddleBox {
  Vec3 middle;
  Vec3 half;
};

/// Holds the box however the numbers are rounded.
MiddleBox middle_box(const Box& box) {
  MiddleBox around{box.center(), {}};
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = around.middle[axis];
    double half = std::max(box.max[axis] - middle, middle - box.min[axis]);
    while (middle - half > box.min[axis] || middle + half < box.max[axis])
      half = std::nextafter(half, kInfinity);
    around.half[axis] = half;
  }
  return around;
}

/// Writes tiles, children before their parent's box is known.
class TileWriter {
 public:
  TileWriter(const Levels& levels, Vec3 origin) : levels_(levels), origin_(origin) {}

  /// `box`: grows to the box that the tile says.
  Json tile(std::uint32_t number, Box& box) const {
    const LevelNode& node = levels_.nodes[number];
    const LevelFacts& facts = levels_.facts[number];
    Json children = Json::array();
    Box around = content_box(facts.bounds);
    for (const std::uint32_t child : node.children) children.push_back(tile(child, around));
    const MiddleBox written = middle_box(around);
    box.extend(Box{written.middle - written.half, written.middle + written.half});
    Json json = {{"boundingVolume", {{"box", box_numbers(written)}}},
                 {"geometricError", facts.error},
                 {"refine", "REPLACE"},
                 {"content", {{"uri", tile_file(number)}}},
                 {"extras", {{"level", node.height}, {"triangles", facts.triangles}}}};
    if (!children.empty()) json["children"] = std::move(children);
    return json;
  }

 private:
  /// About the origin, and as much larger as floats move vertices.
  Box content_box(const Box& bounds) const {
    constexpr double kHalfStep = 0x1p-24;
    const Box local{bounds.min - origin_, bounds.max - origin_};
    return local.grown(bounds.largest_extent() * kHalfStep);
  }
  static Json box_numbers(const MiddleBox& box) {
    return {box.middle.x, box.middle.y, box.middle.z, box.half.x, 0.0, 0.0,
            0.0,          box.half.y,   0.0,          0.0,        0.0, box.half.z};
  }

  const Levels& levels_;
  Vec3 origin_;
};

/// Coordinates about the origin.
Json hole_json(const ListedHole& hole, bool has_confidence, Vec3 origin) {
  const Vec3 middle = hole.bounds.center() - origin;
  Json json = {{"hole", hole.hole},
               {"triangles", hole.triangles},
               {"middle", {middle.x, middle.y, middle.z}},
               {"diagonal", hole.bounds.diagonal()}};
  // A patch that faces nowhere as a whole is looked at from where one is.
  if (const double area = norm(hole.area); area > 0.0)
    json["normal"] = {hole.area.x / area, hole.area.y / area, hole.area.z / area};
  if (has_confidence) json["confidence"] = hole.confidence;
  return json;
}

/// Of a mesh with one component and without patches nothing is said.
Json extras_of(const TaggedFaces& faces, Vec3 origin) {
  constexpr std::size_t kListed = 100;
  Json extras;
  if (!faces.holes.empty()) {
    extras["filled_holes"] = faces.hole_count;
    extras["holes"] = Json::array();
    for (const ListedHole& hole : faces.holes)
      extras["holes"].push_back(hole_json(hole, faces.has_confidence, origin));
  }
  if (faces.components.size() > 1) {
    const std::size_t listed = std::min(faces.components.size(), kListed);
    extras["components"] = faces.components.size();
    extras["component_triangles"] = std::vector<std::uint64_t>(
        faces.components.begin(), faces.components.begin() + static_cast<std::ptrdiff_t>(listed));
  }
  return extras;
}

}  // namespace

std::string tile_file(std::uint32_t node) {
  char text[24];
  std::snprintf(text, sizeof text, "%06u.glb", node);
  return text;
}

Transform upright_transform(int up_axis, Vec3 origin) {
  using Row = std::array<double, 3>;
  std::array<Row, 3> rows = {Row{1, 0, 0}, Row{0, 1, 0}, Row{0, 0, 1}};
  if (up_axis == 0) rows = {Row{0, 0, -1}, Row{0, 1, 0}, Row{1, 0, 0}};
  if (up_axis == 1) rows = {Row{1, 0, 0}, Row{0, 0, -1}, Row{0, 1, 0}};
  Transform transform{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      transform[4 * column + row] = rows[row][column];
    transform[12 + row] =
        rows[row][0] * origin.x + rows[row][1] * origin.y + rows[row][2] * origin.z + 0.0;
  }
  transform[15] = 1.0;
  return transform;
}

std::string tileset_text(const Levels& levels, const TaggedFaces& faces,
                         std::span<const ShownRange> values, Vec3 origin,
                         const Transform& to_world) {
  Box all;
  Json root = TileWriter(levels, origin).tile(0, all);
  root["transform"] = to_world;
  // Without any tile drawn, the whole mesh is missing.
  Json document = {{"asset", {{"version", "1.1"}, {"generator", "orbweave"}}},
                   {"geometricError", std::max(all.diagonal(), levels.facts[0].error)},
                   {"root", std::move(root)}};
  Json extras = extras_of(faces, origin);
  for (const ShownRange& value : values)
    extras["vertex_values"].push_back(
        {{"name", value.name}, {"low", value.low}, {"high", value.high}});
  if (!extras.empty()) document["extras"] = extras;
  return json_dump(document, 1) + "\n";
}

}  // namespace orbweave
