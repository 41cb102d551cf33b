#include "engine/synthetic/scene_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace orbweave::synthetic {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Distance at which the ray enters the box; infinite where it misses the box or enters it beyond
/// `limit`.
double entry(const Box& box, Vec3 origin, Vec3 direction, double limit) {
  double enter = 0.0, leave = limit;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (origin[axis] < box.min[axis] || origin[axis] > box.max[axis]) return kInfinity;
      continue;
    }
    const double a = (box.min[axis] - origin[axis]) / direction[axis];
    const double b = (box.max[axis] - origin[axis]) / direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : kInfinity;
}

}  // namespace

SceneRays::SceneRays(std::span<const SceneTriangle> triangles) {
  for (const SceneTriangle& triangle : triangles) {
    if (triangle.role == SceneRole::kGlass) continue;
    const auto& [a, b, c] = triangle.corners;
    triangles_.push_back({a, b - a, c - a, normalized(cross(b - a, c - a))});
  }
  nodes_.push_back({.box = {}, .first = 0, .count = static_cast<std::uint32_t>(triangles_.size())});
  for (std::size_t node = 0; node < nodes_.size(); ++node) split(node);
}

/// Gives a node its box and, where it holds too many triangles, two children, halves by the
/// triangles' middles along the longest side.
void SceneRays::split(std::size_t node) {
  const std::uint32_t first = nodes_[node].first, count = nodes_[node].count;
  Box box, middles;
  const auto middle = [](const Corners& t) { return t.a + (t.to_b + t.to_c) / 3.0; };
  for (std::uint32_t k = first; k < first + count; ++k) {
    const Corners& t = triangles_[k];
    for (const Vec3 corner : {t.a, t.a + t.to_b, t.a + t.to_c}) box.extend(corner);
    middles.extend(middle(t));
  }
  // Corners are computed from differences again, and rays touch faces of boxes.
  nodes_[node].box = box.grown(1e-12 * (1.0 + box.diagonal()));
  if (count <= kLeafTriangles) return;
  const Vec3 extent = middles.extent();
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const auto begin = triangles_.begin() + first;
  // Stable: which of several equal middles comes first does not depend on the library.
  std::stable_sort(begin, begin + count, [&](const Corners& a, const Corners& b) {
    return middle(a)[axis] < middle(b)[axis];
  });
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({.box = {}, .first = first, .count = count / 2});
  nodes_.push_back({.box = {}, .first = first + count / 2, .count = count - count / 2});
  nodes_[node].first = child;
  nodes_[node].count = 0;
}

std::optional<RayHit> SceneRays::first_hit(Vec3 origin, Vec3 direction) const {
  std::optional<RayHit> best;
  const auto limit = [&] { return best ? best->distance : kInfinity; };
  const auto try_triangle = [&](const Corners& t) {
    const Vec3 p = cross(direction, t.to_c);
    const double determinant = dot(t.to_b, p);
    if (determinant == 0.0) return;
    const Vec3 from_a = origin - t.a;
    const double u = dot(from_a, p) / determinant;
    const Vec3 q = cross(from_a, t.to_b);
    const double v = dot(direction, q) / determinant;
    if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0)) return;
    const double distance = dot(t.to_c, q) / determinant;
    if (distance > 0.0 && distance < limit()) best = RayHit{distance, t.normal};
  };
  std::array<std::uint32_t, 64> stack{};
  std::size_t held = 0;
  stack[held++] = 0;
  while (held > 0) {
    const Node& node = nodes_[stack[--held]];
    if (entry(node.box, origin, direction, limit()) == kInfinity) continue;
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k)
      try_triangle(triangles_[k]);
    if (node.count > 0 || node.first == 0) continue;
    // The nearer child is taken first.
    const double near = entry(nodes_[node.first].box, origin, direction, limit());
    const double far = entry(nodes_[node.first + 1].box, origin, direction, limit());
    stack[held++] = near <= far ? node.first + 1 : node.first;
    stack[held++] = near <= far ? node.first : node.first + 1;
  }
  return best;
}

std::optional<RayHit> cylinder_hit(Vec3 foot, double radius, double height, Vec3 origin,
                                   Vec3 direction) {
  const Vec3 from{origin.x - foot.x, origin.y - foot.y, 0.0};
  const double a = direction.x * direction.x + direction.y * direction.y;
  const double b = from.x * direction.x + from.y * direction.y;
  const double root = b * b - a * (squared_norm(from) - radius * radius);
  if (!(a > 0.0 && root >= 0.0)) return std::nullopt;
  const double distance = (-b - std::sqrt(root)) / a;
  const Vec3 p = origin + distance * direction;
  if (!(distance > 0.0 && p.z >= foot.z && p.z <= foot.z + height)) return std::nullopt;
  return RayHit{distance, Vec3{(p.x - foot.x) / radius, (p.y - foot.y) / radius, 0.0}};
}

std::optional<RayChord> ball_chord(Vec3 center, double radius, Vec3 origin, Vec3 direction) {
  const double middle = dot(center - origin, direction);
  const Vec3 nearest = origin + middle * direction;
  const double square = radius * radius - squared_norm(nearest - center);
  if (!(square > 0.0 && middle > 0.0)) return std::nullopt;
  const double half = std::sqrt(square);
  return RayChord{middle - half, middle + half};
}

}  // namespace orbweave::synthetic
