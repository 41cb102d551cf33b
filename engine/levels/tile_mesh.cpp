#include "engine/levels/tile_mesh.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <map>
#include <utility>

namespace orbweave {
namespace {

/// Vertices with the tag of their faces.
struct SplitVertices {
  std::vector<std::uint32_t> origin;  ///< the node's vertex of each of the tile
  std::vector<FaceTag> tags;
  std::vector<Triangle> triangles;
};

SplitVertices split_by_tags(const NodeMesh& mesh) {
  SplitVertices split;
  split.tags.resize(mesh.vertices.size());
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) split.origin.push_back(v);
  std::vector<bool> has_tag(mesh.vertices.size());
  std::map<std::pair<std::uint32_t, FaceTag>, std::uint32_t> copies;
  const auto place_of = [&](std::uint32_t vertex, const FaceTag& tag) {
    if (!has_tag[vertex]) split.tags[vertex] = tag;
    has_tag[vertex] = true;
    if (split.tags[vertex] == tag) return vertex;
    const auto next = static_cast<std::uint32_t>(split.origin.size());
    const auto [at, is_new] = copies.try_emplace({vertex, tag}, next);
    if (is_new) {
      split.origin.push_back(vertex);
      split.tags.push_back(tag);
    }
    return at->second;
  };
  split.triangles.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle& corners = split.triangles.emplace_back(mesh.triangles[t]);
    for (std::uint32_t& corner : corners) corner = place_of(corner, mesh.tags[t]);
  }
  return split;
}

float value_of(const FaceTag& tag, const std::string& attribute) {
  if (attribute == "hole") return static_cast<float>(tag.hole);
  return attribute == "component" ? static_cast<float>(tag.component) : tag.confidence;
}

}  // namespace

std::vector<std::string> tile_attributes(const NodeMesh& mesh, const TileColumns& columns) {
  std::vector<std::string> names;
  const bool fills = std::ranges::any_of(mesh.tags, [](const FaceTag& t) { return t.hole > 0; });
  if (columns.has_components) names.emplace_back("component");
  if (columns.has_holes && fills) names.emplace_back("hole");
  if (columns.has_confidence && fills) names.emplace_back("confidence");
  return names;
}

TriangleMesh tile_mesh(const PointCloud& points, const NodeMesh& mesh, const TileColumns& columns) {
  const std::vector<std::string> names = tile_attributes(mesh, columns);
  TriangleMesh tile;
  if (names.empty()) {
    tile.vertices = points;
    tile.triangles = mesh.triangles;
    return tile;
  }
  SplitVertices split = split_by_tags(mesh);
  tile.triangles = std::move(split.triangles);
  PointCloud& vertices = tile.vertices;
  vertices.schema = points.schema;
  for (const std::string& name : names)
    vertices.schema.attributes.push_back({name, ScalarType::kFloat32});
  const std::size_t kept_bytes = points.schema.attribute_bytes();
  vertices.reserve(split.origin.size());
  for (std::size_t i = 0; i < split.origin.size(); ++i) {
    const std::size_t from = split.origin[i];
    vertices.positions.push_back(points.positions[from]);
    if (points.schema.has_normals) vertices.normals.push_back(points.normals[from]);
    const auto row = points.attributes.begin() + static_cast<std::ptrdiff_t>(from * kept_bytes);
    vertices.attributes.insert(vertices.attributes.end(), row,
                               row + static_cast<std::ptrdiff_t>(kept_bytes));
    for (const std::string& name : names) {
      const float value = value_of(split.tags[i], name);
      const auto* bytes = reinterpret_cast<const std::byte*>(&value);
      vertices.attributes.insert(vertices.attributes.end(), bytes, bytes + sizeof value);
    }
  }
  return tile;
}

}  // namespace orbweave
