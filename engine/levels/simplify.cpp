#include "engine/levels/simplify.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>

#include "engine/geometry/triangle_tree.h"
#include "engine/levels/flaps.h"
#include "engine/levels/soundness.h"
#include "engine/validation/mesh_facts.h"
#include "io/bounds.h"

namespace orbweave {
namespace {

/// The power of two that the extent of the mesh lies above, so that its floats have the same digits
/// at any scale, and squares of them a place among floats.
int exponent_of(std::span<const Vec3> positions) {
  const double extent = bounds_of(positions).largest_extent();
  return extent > 0.0 && std::isfinite(extent) ? std::ilogb(extent) : 0;
}

/// Floats about the middle of the mesh, in units of 2^exponent.
std::vector<float> floats_of(std::span<const Vec3> positions, int exponent) {
  const Box bounds = bounds_of(positions);
  std::vector<float> floats;
  floats.reserve(3 * positions.size());
  for (const Vec3& position : positions) {
    const Vec3 local = position - bounds.center();
    for (int axis = 0; axis < 3; ++axis)
      floats.push_back(static_cast<float>(std::ldexp(local[axis], -exponent)));
  }
  return floats;
}

TriangleMesh mesh_of(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  TriangleMesh mesh;
  mesh.vertices.positions.assign(positions.begin(), positions.end());
  mesh.triangles.assign(triangles.begin(), triangles.end());
  return mesh;
}

/// Squared, from the vertices that are gone to the new surface; at least `least`.
double distance_of_gone(std::span<const Vec3> positions, std::span<const Triangle> before,
                        std::span<const Triangle> after, double least) {
  const TriangleMesh mesh = mesh_of(positions, after);
  const TriangleTree tree(mesh);
  const std::vector<std::uint8_t> was = used_vertices(positions.size(), before);
  const std::vector<std::uint8_t> stays = used_vertices(positions.size(), after);
  double largest = least;
  for (std::size_t i = 0; i < positions.size(); ++i)
    if (was[i] != 0 && stays[i] == 0)
      largest = std::max(largest, tree.squared_distance_beyond(positions[i], largest));
  return largest;
}

/// Squared, from four points of each new triangle to the old surface; at least `least`.
double distance_of_new(std::span<const Vec3> positions, std::span<const Triangle> before,
                       std::span<const Triangle> after, double least) {
  using Weights = std::array<double, 3>;
  constexpr std::array<Weights, 4> kPlaces = {
      Weights{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, Weights{2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0},
      Weights{1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0}, Weights{1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0}};
  const TriangleMesh mesh = mesh_of(positions, before);
  const TriangleTree tree(mesh);
  double largest = least;
  for (const Triangle& t : after)
    for (const Weights& w : kPlaces) {
      const Vec3 place = w[0] * positions[t[0]] + w[1] * positions[t[1]] + w[2] * positions[t[2]];
      largest = std::max(largest, tree.squared_distance_beyond(place, largest));
    }
  return largest;
}

/// Between the two surfaces, both ways, where it is measured; at least `least`, which saves the
/// search for what is nearer.
double measured_distance(std::span<const Vec3> positions, std::span<const Triangle> before,
                         std::span<const Triangle> after, double least) {
  if (after.empty()) return bounds_of(positions).diagonal();
  const double of_gone = distance_of_gone(positions, before, after, least * least);
  return std::sqrt(distance_of_new(positions, before, after, of_gone));
}

/// Triangles that add_locks() adds for each vertex.
constexpr std::size_t kTrianglesOfLock = 2;

/// Two further triangles at each locked vertex, to four vertices that all of them share.
/// meshoptimizer locks vertices at which more than two edges are open, the four as well, and has no
/// other way to lock single vertices before its version 0.20. So none of these triangles goes.
void add_locks(std::span<const std::uint32_t> locked, std::vector<float>& floats,
               std::vector<Triangle>& triangles) {
  if (locked.empty()) return;
  float reach = 0.0F;
  for (const float number : floats) reach = std::max(reach, std::abs(number));
  // Near the middle, so that the mesh has the extent that it had.
  const float aside = reach * 0x1p-10F;
  const auto first = static_cast<std::uint32_t>(floats.size() / 3);
  for (const float step : {aside, -aside, 2.0F * aside, -2.0F * aside})
    floats.insert(floats.end(), {step, step * step / reach, 0.0F});
  for (const std::uint32_t vertex : locked) {
    triangles.push_back({vertex, first, first + 1});
    triangles.push_back({vertex, first + 2, first + 3});
  }
}

/// As meshoptimizer takes limits of errors.
float relative_limit(double error, double scale) {
  constexpr double kMost = std::numeric_limits<float>::max();
  return static_cast<float>(scale > 0.0 ? std::min(error / scale, kMost) : kMost);
}

Simplification unchanged(std::span<const Triangle> triangles) {
  return {{triangles.begin(), triangles.end()}, 0.0, true};
}

/// Triangles on the way, and the quadrics' error of the last step.
struct Step {
  std::vector<Triangle> triangles;
  double error = 0.0;
  bool is_sound = false;
};

/// Simplifies in steps to half, each from what the one before left: where an edge collapse has made
/// the surface touch itself, what lies around it is locked, and the step is made again. In steps to
/// half that is a small part of the mesh.
class SoundSimplifier {
 public:
  SoundSimplifier(std::span<const Vec3> positions, std::span<const Triangle> triangles,
                  std::span<const std::uint32_t> locked)
      : positions_(positions),
        locked_(locked),
        exponent_(exponent_of(positions)),
        floats_(floats_of(positions, exponent_)),
        scale_(std::ldexp(
            static_cast<double>(meshopt_simplifyScale(floats_.data(), positions.size(), kStride)),
            exponent_)),
        unsound_before_(unsound_vertices(triangles)) {}

  Step simplify(std::span<const Triangle> triangles, const SimplifyLimits& limits) const {
    Step all{{triangles.begin(), triangles.end()}, 0.0, true};
    while (all.triangles.size() > limits.triangles) {
      const std::size_t half = std::max(limits.triangles, all.triangles.size() / 2);
      Step next = sound_step(all.triangles, half, limits.quadric_error - all.error);
      if (next.triangles.size() >= all.triangles.size()) break;
      const bool is_last = next.triangles.size() > half;
      all = {std::move(next.triangles), all.error + next.error, all.is_sound && next.is_sound};
      if (is_last) break;
    }
    return all;
  }

 private:
  static constexpr std::size_t kStride = 3 * sizeof(float);

  Step sound_step(const std::vector<Triangle>& triangles, std::size_t target,
                  double quadric_error) const {
    constexpr int kAttempts = 10;
    const std::vector<EdgeEnds> border_edges = edges_among(triangles, locked_);
    std::vector<std::uint32_t> locks(locked_.begin(), locked_.end());
    Step best;
    std::size_t fewest = std::numeric_limits<std::size_t>::max();
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      Step step = collapsed(triangles, locks, target, quadric_error);
      std::vector<std::uint32_t> unsound = newly_unsound(step.triangles, border_edges);
      if (!unsound.empty()) {
        step.triangles = without_flaps(step.triangles, unsound, locked_);
        unsound = newly_unsound(step.triangles, border_edges);
      }
      step.is_sound = unsound.empty();
      if (step.is_sound) return step;
      lock_around(unsound, triangles, locks);
      if (unsound.size() >= fewest) continue;
      fewest = unsound.size();
      best = std::move(step);
    }
    return best;
  }

  /// What meshoptimizer makes of the triangles.
  Step collapsed(const std::vector<Triangle>& triangles, std::span<const std::uint32_t> locks,
                 std::size_t target, double quadric_error) const {
    std::vector<float> floats = floats_;
    std::vector<Triangle> with_locks = triangles;
    add_locks(locks, floats, with_locks);
    Step step;
    step.triangles.resize(with_locks.size());
    float relative_error = 0.0F;
    const std::size_t indices = meshopt_simplify(
        step.triangles.front().data(), with_locks.front().data(), 3 * with_locks.size(),
        floats.data(), floats.size() / 3, kStride, 3 * (target + kTrianglesOfLock * locks.size()),
        relative_limit(quadric_error, scale_), 0, &relative_error);
    step.triangles.resize(indices / 3);
    std::erase_if(step.triangles, [&](const Triangle& t) {
      return std::max({t[0], t[1], t[2]}) >= positions_.size();
    });
    step.error = static_cast<double>(relative_error) * scale_;
    return step;
  }

  /// Where the triangles are no manifold and the mesh was one, and the ends of new edges between
  /// vertices of the border: what lies beyond it may have the same edge.
  std::vector<std::uint32_t> newly_unsound(std::span<const Triangle> triangles,
                                           const std::vector<EdgeEnds>& border_edges) const {
    std::vector<std::uint32_t> unsound;
    const std::vector<std::uint32_t> now = unsound_vertices(triangles);
    std::set_difference(now.begin(), now.end(), unsound_before_.begin(), unsound_before_.end(),
                        std::back_inserter(unsound));
    for (const EdgeEnds& edge : edges_among(triangles, locked_)) {
      if (std::binary_search(border_edges.begin(), border_edges.end(), edge)) continue;
      unsound.push_back(edge.low);
      unsound.push_back(edge.high);
    }
    std::sort(unsound.begin(), unsound.end());
    return unsound;
  }

  /// Locks an unsound vertex and its neighbours: its triangles are then as they are, sound.
  static void lock_around(const std::vector<std::uint32_t>& unsound,
                          std::span<const Triangle> triangles, std::vector<std::uint32_t>& locks) {
    const auto is_unsound = [&](std::uint32_t vertex) {
      return std::binary_search(unsound.begin(), unsound.end(), vertex);
    };
    for (const Triangle& t : triangles)
      if (std::ranges::any_of(t, is_unsound)) locks.insert(locks.end(), t.begin(), t.end());
    std::sort(locks.begin(), locks.end());
    locks.erase(std::unique(locks.begin(), locks.end()), locks.end());
  }

  std::span<const Vec3> positions_;
  std::span<const std::uint32_t> locked_;  ///< ascending
  int exponent_;                           ///< of the unit of floats_
  std::vector<float> floats_;              ///< of the positions, about their middle
  double scale_;                           ///< that meshoptimizer's errors are parts of
  std::vector<std::uint32_t> unsound_before_;
};

constexpr std::size_t kTetrahedron = 4;

/// The fewest triangles that are left of these, so that the surface does not vanish: those of a
/// tetrahedron where it is closed, one where it is a sheet.
std::size_t fewest_triangles(std::span<const Triangle> triangles) {
  std::vector<EdgeEnds> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (std::size_t c = 0; c < 3; ++c)
      edges.push_back({std::min(t[c], t[(c + 1) % 3]), std::max(t[c], t[(c + 1) % 3])});
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size(); i += 2)
    if (i + 1 == edges.size() || edges[i] != edges[i + 1]) return 1;
  return kTetrahedron;
}

}  // namespace

Simplification simplify_between(std::span<const Vec3> positions,
                                std::span<const Triangle> triangles,
                                std::span<const std::uint32_t> locked,
                                const SimplifyLimits& limits) {
  if (triangles.size() <= limits.triangles) return unchanged(triangles);
  SoundSimplifier simplifier(positions, triangles, locked);
  Step step = simplifier.simplify(triangles, limits);
  if (step.triangles.size() < kTetrahedron) {
    const std::size_t fewest = fewest_triangles(triangles);
    // Of few triangles, some of which lay back to back in the mesh, all may go as flaps.
    for (std::size_t most = fewest; step.triangles.size() < fewest; most *= 2) {
      if (most >= triangles.size()) return unchanged(triangles);
      step = simplifier.simplify(triangles, {most, limits.quadric_error});
    }
  }
  // Points between those that are measured may be farther away.
  constexpr double kBetween = 1.25;
  // Rounded down: what is nearer counts for nothing beside the quadrics' error.
  const double least = (1.0 - 1e-9) * step.error / kBetween;
  Simplification result{std::move(step.triangles), 0.0, step.is_sound};
  result.error = std::max(
      step.error, kBetween * measured_distance(positions, triangles, result.triangles, least));
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
    if (result.is_sound && result.error <= error) return result;
    quadric_error *= std::clamp(kSafety * error / result.error, 0.1, 0.8);
  }
  return unchanged(triangles);
}

}  // namespace orbweave
