#include "engine/synthetic/scene.h"

#include <algorithm>

namespace orbweave {
namespace {

constexpr std::array<SceneKind, 3> kScenes = {SceneKind::kRoom, SceneKind::kHouse,
                                              SceneKind::kFrames};
constexpr std::array<std::string_view, 3> kSceneNames = {"room", "house", "frames"};

}  // namespace

std::string_view name_of(SceneKind kind) { return kSceneNames[static_cast<std::size_t>(kind)]; }

std::optional<SceneKind> scene_named(std::string_view name) {
  for (const SceneKind kind : kScenes)
    if (name == name_of(kind)) return kind;
  return std::nullopt;
}

std::span<const SceneKind> all_scenes() { return kScenes; }

namespace synthetic {
namespace {

/// Twice the area, along the normal.
Vec3 area_vector(const SceneTriangle& triangle) {
  const auto& [a, b, c] = triangle.corners;
  return cross(b - a, c - a);
}

}  // namespace

Scene scene_of(SceneKind kind) {
  switch (kind) {
    case SceneKind::kHouse:
      return house_scene();
    case SceneKind::kFrames:
      return frames_scene();
    default:
      return room_scene();
  }
}

double truth_area(const Scene& scene) {
  double sum = 0.0;
  for (const SceneTriangle& triangle : scene.triangles)
    if (triangle.role != SceneRole::kClutter) sum += 0.5 * norm(area_vector(triangle));
  return sum;
}

TriangleMesh truth_mesh(const Scene& scene) {
  TriangleMesh mesh;
  PointCloud& vertices = mesh.vertices;
  vertices.schema.has_normals = true;
  vertices.schema.normal_type = ScalarType::kFloat64;
  vertices.schema.attributes = {{"pane", ScalarType::kUint8}};
  for (const SceneTriangle& triangle : scene.triangles) {
    if (triangle.role == SceneRole::kClutter) continue;
    const auto first = static_cast<std::uint32_t>(vertices.positions.size());
    for (const Vec3 corner : triangle.corners) {
      vertices.positions.push_back(corner);
      vertices.normals.push_back(normalized(area_vector(triangle)));
      vertices.attributes.push_back(static_cast<std::byte>(triangle.pane));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

}  // namespace synthetic
}  // namespace orbweave
