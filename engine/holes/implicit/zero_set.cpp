#include "engine/holes/implicit/zero_set.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "engine/holes/patch/smooth_disc.h"
#include "engine/holes/rbf/rbf.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// s / |grad s|, the distance from the zero set to first order, and the direction away from it.
struct Offset {
  double distance = std::numeric_limits<double>::infinity();
  Vec3 direction;
  double slope = 0.0;
};

Offset offset_from(const RbfInterpolant& rbf, Vec3 p) {
  const RbfInterpolant::ValueGradient at = rbf.evaluate_with_gradient(p);
  const double slope = norm(at.gradient);
  if (!(slope > 0.0)) return {};
  return {at.value / slope, at.gradient / slope, slope};
}

/// How to reach the zero set: Newton steps along the gradient.
struct Descent {
  double longest = 0.0;  ///< of a step
  double close = 0.0;    ///< distance at which the last step is taken
  int steps = 0;
};

/// Moves p to the zero set; what was known before the last step.
Offset project(const RbfInterpolant& rbf, const Descent& descent, Vec3& p) {
  Offset offset;
  for (int step = 0; step < descent.steps; ++step) {
    offset = offset_from(rbf, p);
    if (offset.slope == 0.0) break;
    p = p - std::clamp(offset.distance, -descent.longest, descent.longest) * offset.direction;
    if (std::abs(offset.distance) <= descent.close) break;
  }
  return offset;
}

/// The interior points that triangles use, ascending.
std::vector<std::uint32_t> inner_points(const PatchMesh& disc) {
  std::vector<char> is_used(disc.size(), 0);
  for (const CornerTriangle& t : disc.triangles())
    for (const std::uint32_t v : t) is_used[v] = 1;
  std::vector<std::uint32_t> points;
  for (std::uint32_t v = disc.corners(); v < disc.size(); ++v)
    if (is_used[v] != 0) points.push_back(v);
  return points;
}

/// Moves interior points towards their neighbours' mean, along the zero set. `normals`: per point.
void relax(std::span<const std::uint32_t> points, std::span<const Vec3> normals, PatchMesh& disc) {
  constexpr double kStep = 0.5;
  const std::vector<std::vector<std::uint32_t>> neighbors = disc.neighbors();
  const std::vector<Vec3> before = disc.positions();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::uint32_t v = points[i];
    Vec3 mean;
    for (const std::uint32_t other : neighbors[v]) mean = mean + before[other];
    const Vec3 move = mean / static_cast<double>(neighbors[v].size()) - before[v];
    disc.positions()[v] = before[v] + kStep * (move - dot(move, normals[i]) * normals[i]);
  }
}

/// Calls visit(0) to visit(count - 1), by several threads where there are many points. Some hundred
/// evaluations of a thousand sites take a hundredth of a second at most.
template <class Visit>
void for_each_point(std::size_t count, const StopToken* stop, const Visit& visit) {
  constexpr std::size_t kBlock = 128;
  constexpr std::size_t kShared = 4 * kBlock;
  const std::size_t block = count < kShared ? count : kBlock;
  if (count == 0) return;
  const auto visit_block = [&](std::size_t b) {
    check_stop(stop);
    for (std::size_t i = b * block; i < std::min(count, (b + 1) * block); ++i) visit(i);
  };
  if (block == count) return visit_block(0);
  for_each_whole((count + block - 1) / block, visit_block);
}

/// Brings the disc onto the zero set and keeps its triangles well shaped meanwhile.
void settle(const RbfInterpolant& rbf, const Rim& rim, const PatchOptions& options,
            PatchMesh& disc) {
  // A large disc starts near enough.
  constexpr std::size_t kLarge = 600;
  const int rounds = inner_points(disc).size() < kLarge ? 6 : 3;
  const double longest = std::max(0.5 * rim.spacing, 0.1 * rim.radius);
  const Descent rough{longest, 0.05 * rim.spacing, 2};
  for (int round = 0; round < rounds; ++round) {
    const std::vector<std::uint32_t> points = inner_points(disc);
    std::vector<Vec3> normals(points.size());
    for_each_point(points.size(), options.stop, [&](std::size_t i) {
      normals[i] = project(rbf, rough, disc.positions()[points[i]]).direction;
    });
    relax(points, normals, disc);
    disc.collapse_short_edges(kShortestEdge * rim.spacing);
    if (points.size() < options.max_new_points) {
      disc.split_long_edges(kLongestEdge * rim.spacing,
                            options.max_new_points - static_cast<std::uint32_t>(points.size()),
                            options.stop);
    }
    disc.flip_to_delaunay();
  }
  const Descent fine{longest, 1e-3 * rim.spacing, 8};
  const std::vector<std::uint32_t> points = inner_points(disc);
  for_each_point(points.size(), options.stop,
                 [&](std::size_t i) { project(rbf, fine, disc.positions()[points[i]]); });
}

/// Whether the disc lies on the zero set in folds. A few faces that look the wrong way are none:
/// beside a ragged rim they cannot help it.
bool is_folded(const RbfInterpolant& rbf, const PatchMesh& disc) {
  constexpr std::size_t kSample = 400;  // of a large disc, spread over it
  const std::vector<CornerTriangle> triangles = disc.triangles();
  const std::size_t stride = std::max<std::size_t>(1, triangles.size() / kSample);
  std::size_t turned = 0;
  for (std::size_t i = 0; i < triangles.size(); i += stride) {
    const CornerTriangle& t = triangles[i];
    const Vec3 a = disc.positions()[t[0]], b = disc.positions()[t[1]], c = disc.positions()[t[2]];
    const Vec3 direction = offset_from(rbf, (a + b + c) / 3.0).direction;
    turned += dot(cross(b - a, c - a), direction) < 0.0 ? 1 : 0;
  }
  return turned > 2 + triangles.size() / stride / 50;
}

/// What is wrong with a disc on the zero set; empty: nothing. `offsets`: of its inner points.
std::string fault_of(const RbfInterpolant& rbf, const Rim& rim, const PatchMesh& disc,
                     std::span<const std::uint32_t> points, std::span<const Offset> offsets) {
  constexpr double kSlack = 0.05;       // of the rim's spacing, distance from the zero set
  constexpr double kLeastSlope = 0.05;  // the data have slope 1
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p = disc.positions()[points[i]];
    if (!is_finite(p) || norm(p) > 3.0 * rim.radius) return "the zero set runs away";
    const Offset& offset = offsets[i];
    if (!(offset.slope > kLeastSlope) || std::abs(offset.distance) > kSlack * rim.spacing) {
      return "no zero set near";
    }
  }
  if (is_folded(rbf, disc)) return "the zero set folds";
  return {};
}

}  // namespace

ZeroSetPatch patch_on_zero_set(const HoleProblem& problem, const Rim& rim,
                               const SignedDistances& distances, RbfKernel kernel, PatchMesh disc,
                               const PatchOptions& options) {
  RbfOptions rbf_options;
  rbf_options.dimension = 3;
  rbf_options.kernel = kernel;
  rbf_options.max_sites = options.max_sites;
  const RbfInterpolant rbf(distances.points, distances.values, 1, rbf_options);
  if (!rbf.valid()) return {{}, "the system is singular"};
  settle(rbf, rim, options, disc);
  const std::vector<std::uint32_t> points = inner_points(disc);
  std::vector<Offset> offsets(points.size());
  for_each_point(points.size(), options.stop, [&](std::size_t i) {
    offsets[i] = offset_from(rbf, disc.positions()[points[i]]);
  });
  std::string fault = fault_of(rbf, rim, disc, points, offsets);
  if (!fault.empty()) return {{}, std::move(fault)};
  // The patch has the inner points in the disc's order, and no others.
  HolePatch patch = patch_of_disc(problem, rim, disc);
  patch.method = FillMethod::kImplicit;
  for (std::size_t i = 0; i < points.size(); ++i) patch.normals[i] = offsets[i].direction;
  patch.sites = rbf.sites();
  patch.residual = rbf.residual();
  patch.condition = rbf.condition();
  return {std::move(patch), {}};
}

}  // namespace orbweave
