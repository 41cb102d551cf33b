#include "engine/levels/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/geometry/triangle_tree.h"
#include "io/bounds.h"

namespace orbweave {
namespace {

/// Floats about the middle of the mesh.
std::vector<float> floats_of(std::span<const Vec3> positions) {
  const Box bounds = bounds_of(positions);
  std::vector<float> floats;
  floats.reserve(3 * positions.size());
  for (const Vec3& position : positions) {
    const Vec3 local = position - bounds.center();
    for (int axis = 0; axis < 3; ++axis) floats.push_back(static_cast<float>(local[axis]));
  }
  return floats;
}

TriangleMesh mesh_of(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  TriangleMesh mesh;
  mesh.vertices.positions.assign(positions.begin(), positions.end());
  mesh.triangles.assign(triangles.begin(), triangles.end());
  return mesh;
}

std::vector<bool> used_vertices(std::size_t vertices, std::span<const Triangle> triangles) {
  std::vector<bool> used(vertices);
  for (const Triangle& t : triangles)
    for (const std::uint32_t corner : t) used[corner] = true;
  return used;
}

/// Squared, from the vertices that are gone to the new surface.
double distance_of_gone(std::span<const Vec3> positions, std::span<const Triangle> before,
                        std::span<const Triangle> after) {
  const TriangleMesh mesh = mesh_of(positions, after);
  const TriangleTree tree(mesh);
  const std::vector<bool> was = used_vertices(positions.size(), before);
  const std::vector<bool> stays = used_vertices(positions.size(), after);
  double largest = 0.0;
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (was[i] && !stays[i]) largest = std::max(largest, tree.squared_distance(positions[i]));
  return largest;
}

/// Squared, from four points of each new triangle to the old surface.
double distance_of_new(std::span<const Vec3> positions, std::span<const Triangle> before,
                       std::span<const Triangle> after) {
  using Weights = std::array<double, 3>;
  constexpr std::array<Weights, 4> kPlaces = {
      Weights{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, Weights{2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0},
      Weights{1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0}, Weights{1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0}};
  const TriangleMesh mesh = mesh_of(positions, before);
  const TriangleTree tree(mesh);
  double largest = 0.0;
  for (const Triangle& t : after)
    for (const Weights& w : kPlaces)
      largest =
          std::max(largest, tree.squared_distance(w[0] * positions[t[0]] + w[1] * positions[t[1]] +
                                                  w[2] * positions[t[2]]));
  return largest;
}

/// Between the two surfaces, both ways, where it is measured.
double measured_distance(std::span<const Vec3> positions, std::span<const Triangle> before,
                         std::span<const Triangle> after) {
  if (after.empty()) return bounds_of(positions).diagonal();
  return std::sqrt(std::max(distance_of_gone(positions, before, after),
                            distance_of_new(positions, before, after)));
}

/// A triangle of its own at each locked vertex. meshoptimizer locks vertices at which a mesh is no
/// surface, and has no other way to lock single vertices before its version 0.20.
void add_locks(std::span<const std::uint32_t> locked, std::vector<float>& floats,
               std::vector<Triangle>& triangles) {
  float reach = 0.0F;
  for (const float number : floats) reach = std::max(reach, std::abs(number));
  // Towards the middle, so that the mesh has the extent that it had.
  constexpr float kInward = 1.0F - 0x1p-8F;
  const float aside = reach * 0x1p-10F;
  for (const std::uint32_t vertex : locked) {
    const auto at = static_cast<std::uint32_t>(floats.size() / 3);
    for (std::size_t corner = 0; corner < 2; ++corner)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float inward = kInward * floats[3 * std::size_t{vertex} + axis];
        floats.push_back(axis == corner ? inward + (inward > 0.0F ? -aside : aside) : inward);
      }
    triangles.push_back({vertex, at, at + 1});
  }
}

/// As meshoptimizer takes limits of errors.
float relative_limit(double error, double scale) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return static_cast<float>(scale > 0.0 ? std::min(error / scale, kMost) : kMost);
}

Simplification unchanged(std::span<const Triangle> triangles) {
  return {{triangles.begin(), triangles.end()}, 0.0};
}

}  // namespace

Simplification simplify_between(std::span<const Vec3> positions,
                                std::span<const Triangle> triangles,
                                std::span<const std::uint32_t> locked,
                                const SimplifyLimits& limits) {
  if (triangles.size() <= limits.triangles) return unchanged(triangles);
  Simplification result;
  std::vector<float> floats = floats_of(positions);
  std::vector<Triangle> with_locks(triangles.begin(), triangles.end());
  add_locks(locked, floats, with_locks);
  result.triangles.resize(with_locks.size());
  constexpr std::size_t kStride = 3 * sizeof(float);
  const std::size_t vertices = floats.size() / 3;
  const auto scale = static_cast<double>(meshopt_simplifyScale(floats.data(), vertices, kStride));
  float relative_error = 0.0F;
  const std::size_t indices = meshopt_simplify(
      result.triangles.front().data(), with_locks.front().data(), 3 * with_locks.size(),
      floats.data(), vertices, kStride, 3 * limits.triangles,
      relative_limit(limits.quadric_error, scale), 0, &relative_error);
  result.triangles.resize(indices / 3);
  std::erase_if(result.triangles, [&](const Triangle& t) {
    return std::max({t[0], t[1], t[2]}) >= positions.size();
  });
  const double quadric_error = static_cast<double>(relative_error) * scale;
  // Points between those that are measured may be farther away.
  constexpr double kBetween = 1.25;
  result.error =
      std::max(quadric_error, kBetween * measured_distance(positions, triangles, result.triangles));
  return result;
}

Simplification simplify_within(std::span<const Vec3> positions, std::span<const Triangle> triangles,
                               std::span<const std::uint32_t> locked, double error) {
  // What is measured mostly exceeds the quadrics' error, by a factor that varies little.
  constexpr int kAttempts = 6;
  constexpr double kSafety = 0.9;
  double quadric_error = error;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Simplification result = simplify_between(positions, triangles, locked, {0, quadric_error});
    if (result.error <= error) return result;
    quadric_error *= std::clamp(kSafety * error / result.error, 0.1, 0.8);
  }
  return unchanged(triangles);
}

}  // namespace orbweave
