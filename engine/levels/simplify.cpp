#include "engine/levels/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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

/// The largest distance from points of triangles to a surface, from above.
///
/// The distance to one triangle C of the surface is a convex function, so that within a triangle T
/// it is largest at a corner of T: no point of T is farther from the surface than the farthest
/// corner is from C. C is the triangle nearest to the middle of T. Where that says too much, T is
/// cut in four.
class LargestDistance {
 public:
  /// `known`: a distance that is stated anyway; what lies below need not be told apart.
  LargestDistance(std::span<const Vec3> positions, std::span<const Triangle> surface, double known)
      : mesh_(mesh_of(positions, surface)), tree_(mesh_), known_(known), bound_(known) {}

  void add(Vec3 a, Vec3 b, Vec3 c, int cuts_left = kMostCuts) {
    const Vec3 middle = (1.0 / 3.0) * (a + b + c);
    const TriangleTree::Nearest nearest = tree_.nearest(middle);
    farthest_seen_ = std::max(farthest_seen_, std::sqrt(nearest.squared_distance));
    const double bound = farthest_corner(a, b, c, mesh_.triangles[nearest.item]);
    if (bound <= std::max(known_, kSlack * farthest_seen_) || cuts_left == 0) {
      bound_ = std::max(bound_, bound);
      return;
    }
    const Vec3 ab = 0.5 * (a + b);
    const Vec3 bc = 0.5 * (b + c);
    const Vec3 ca = 0.5 * (c + a);
    add(a, ab, ca, cuts_left - 1);
    add(b, bc, ab, cuts_left - 1);
    add(c, ca, bc, cuts_left - 1);
    add(ab, bc, ca, cuts_left - 1);
  }
  double bound() const { return bound_; }

 private:
  static constexpr int kMostCuts = 5;
  static constexpr double kSlack = 1.1;

  double farthest_corner(Vec3 a, Vec3 b, Vec3 c, const Triangle& of) const {
    double farthest = 0.0;
    for (const Vec3& corner : {a, b, c})
      farthest = std::max(
          farthest, squared_distance_to_triangle(corner, mesh_.vertices.positions[of[0]],
                                                 mesh_.vertices.positions[of[1]],
                                                 mesh_.vertices.positions[of[2]]));
    return std::sqrt(farthest);
  }

  TriangleMesh mesh_;
  TriangleTree tree_;
  double known_;
  double bound_;
  double farthest_seen_ = 0.0;
};

/// Between the two surfaces, both ways; at least `known`.
double largest_distance(std::span<const Vec3> positions, std::span<const Triangle> before,
                        std::span<const Triangle> after, double known) {
  if (after.empty()) return std::max(known, bounds_of(positions).diagonal());
  for (const auto& [from, to] : {std::pair(before, after), std::pair(after, before)}) {
    LargestDistance distance(positions, to, known);
    for (const Triangle& t : from) distance.add(positions[t[0]], positions[t[1]], positions[t[2]]);
    known = distance.bound();
  }
  return known;
}

}  // namespace

Simplification simplify_inside(std::span<const Vec3> positions,
                               std::span<const Triangle> triangles, std::size_t target) {
  Simplification result;
  if (triangles.size() <= target) {
    result.triangles.assign(triangles.begin(), triangles.end());
    return result;
  }
  const std::vector<float> floats = floats_of(positions);
  result.triangles.resize(triangles.size());
  constexpr std::size_t kStride = 3 * sizeof(float);
  constexpr float kAnyError = std::numeric_limits<float>::max();
  float relative_error = 0.0F;
  const std::size_t indices =
      meshopt_simplify(result.triangles.front().data(), triangles.front().data(),
                       3 * triangles.size(), floats.data(), positions.size(), kStride, 3 * target,
                       kAnyError, meshopt_SimplifyLockBorder, &relative_error);
  result.triangles.resize(indices / 3);
  const double quadric_error =
      static_cast<double>(relative_error) *
      static_cast<double>(meshopt_simplifyScale(floats.data(), positions.size(), kStride));
  result.error = largest_distance(positions, triangles, result.triangles, quadric_error);
  return result;
}

}  // namespace orbweave
