#include "engine/cleaning/projection.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "engine/geometry/local_surface.h"
#include "engine/geometry/neighbor_grid.h"
#include "io/error.h"

namespace orbweave {
namespace {

/// A neighbour supports a normal when the cosine between the two is more than that,
constexpr double kSupports = 0.7;
/// and a normal counts as right when it has that share of the neighbours' weight: half of them do
/// at an edge or on a thin wall.
constexpr double kSupport = 0.5;
/// Normals of which the mean is shorter are of two sheets, and it tells nothing.
constexpr double kOneSheet = 0.4;
/// Means of normals around the reference normal; it settles fast.
constexpr int kMeans = 2;
/// Points in a cube of the radius as side, where a projection takes a millisecond per point.
constexpr double kMostInACell = 10000.0;
/// Points between two looks at the request to stop.
constexpr std::ptrdiff_t kLookEvery = 64;

/// Squared distance in radii that still counts: a hair less than the halo that chunks are cut with.
constexpr double kReach = 1.0 - 1e-12;

/// A bell in the squared distance in radii: much like exp(-2 t), but zero at the radius, and of the
/// same bits on every machine.
double bell(double t) { return (1.0 - t) * (1.0 - t); }

/// Projects the points of one cell of the grid after the other.
class Projector {
 public:
  Projector(std::span<const Vec3> positions, std::span<const Vec3> normals,
            const ProjectionOptions& options, const NeighborGrid& grid)
      : positions_(positions), normals_(normals), options_(options), grid_(grid) {}

  void enter(std::uint32_t cell) { grid_.gather(cell, cells_, candidates_); }

  /// The local surface around a point of the cell.
  std::optional<LocalSurface> surface_at(std::uint32_t point) {
    find_near(point);
    const Vec3 reference = reference_normal(normals_[point]);
    samples_.clear();
    for (const Near& near : near_) {
      const double agreement = agreement_of(near, reference);
      if (agreement == 0.0) continue;
      // Distance along the surface: a point far above it is not drawn to what lies near itself.
      const double along = dot(near.offset, reference);
      const double weight = agreement * agreement * bell(near.squared - along * along);
      if (weight > 0.0) samples_.push_back({near.offset, weight});
    }
    return fit_surface(samples_, reference);
  }

 private:
  struct Near {
    Vec3 offset;  ///< in radii
    double squared = 0.0;
    Vec3 normal;
  };

  void find_near(std::uint32_t point) {
    near_.clear();
    const double scale = 1.0 / options_.radius;
    for (const std::uint32_t other : candidates_) {
      const Vec3 offset = scale * (positions_[other] - positions_[point]);
      const double squared = squared_norm(offset);
      if (squared <= kReach) near_.push_back({offset, squared, normals_[other]});
    }
  }

  double agreement_of(const Near& near, Vec3 reference) const {
    const double cosine = dot(near.normal, reference);
    return options_.oriented ? std::max(0.0, cosine) : std::abs(cosine);
  }

  /// The point's own normal, or what those around suggest where they do not support it: one
  /// estimated in the thick of layers may point anywhere.
  Vec3 reference_normal(Vec3 own) const {
    Vec3 reference = is_supported(own) ? own : mean_normal(own);
    for (int mean = 0; mean < kMeans; ++mean) {
      Vec3 sum;
      for (const Near& near : near_) {
        const double sign = dot(near.normal, reference) < 0.0 ? -1.0 : 1.0;
        sum = sum + sign * bell(near.squared) * agreement_of(near, reference) * near.normal;
      }
      if (squared_norm(sum) > 0.0) reference = normalized(sum);
    }
    return reference;
  }

  /// Normals of either sign have no mean: there, the own one has to do.
  bool is_supported(Vec3 own) const {
    if (!options_.oriented) return true;
    double support = 0.0, weight = 0.0;
    for (const Near& near : near_) {
      const double bell_weight = bell(near.squared);
      if (agreement_of(near, own) > kSupports) support += bell_weight;
      weight += bell_weight;
    }
    return support >= kSupport * weight;
  }

  Vec3 mean_normal(Vec3 own) const {
    Vec3 sum;
    double weight = 0.0;
    for (const Near& near : near_) {
      sum = sum + bell(near.squared) * near.normal;
      weight += bell(near.squared);
    }
    return norm(sum) > kOneSheet * weight ? normalized(sum) : own;
  }

  std::span<const Vec3> positions_, normals_;
  ProjectionOptions options_;
  const NeighborGrid& grid_;
  std::vector<std::uint32_t> cells_, candidates_;
  std::vector<Near> near_;
  std::vector<SurfaceSample> samples_;
};

/// A point's time is that of its neighbours, of which there are some three times as many as points
/// in its cell.
void refuse_too_many(const NeighborGrid& grid, std::size_t points, const std::string& radius_name) {
  double pairs = 0.0;
  for (std::uint32_t cell = 0; cell < grid.cells(); ++cell) {
    const auto members = static_cast<double>(grid.members(cell).size());
    pairs += members * members;
  }
  const double mean = pairs / static_cast<double>(points);
  if (!(mean > kMostInACell)) return;
  throw_usage(
      "the radius of smoothing is far wider than the points are apart",
      {.place = radius_name,
       .found = std::to_string(std::llround(mean)) + " points in an average cube of that side",
       .expected =
           "at most " + std::to_string(std::llround(kMostInACell)) + " (some 15 are the rule)",
       .advice = "Choose a smaller radius: about four times the distance between "
                 "neighbouring points."});
}

}  // namespace

ProjectedPoints project_points(std::span<const Vec3> positions, std::span<const Vec3> normals,
                               std::uint32_t begin, std::uint32_t end,
                               const ProjectionOptions& options) {
  ProjectedPoints result;
  result.positions.assign(positions.begin() + begin, positions.begin() + end);
  result.normals.assign(normals.begin() + begin, normals.begin() + end);
  result.moved.assign(end - begin, 0);
  const NeighborGrid grid(positions, options.radius);
  refuse_too_many(grid, positions.size(), options.radius_name);
  tbb::enumerable_thread_specific<Projector> projectors(
      [&] { return Projector(positions, normals, options, grid); });
  tbb::parallel_for(std::uint32_t{0}, grid.cells(), [&](std::uint32_t cell) {
    const auto members = grid.members(cell);
    const auto first = std::lower_bound(members.begin(), members.end(), begin);
    const auto last = std::lower_bound(first, members.end(), end);
    if (first == last) return;
    Projector& projector = projectors.local();
    projector.enter(cell);
    for (auto it = first; it != last; ++it) {
      if ((it - first) % kLookEvery == 0) check_stop(options.stop);
      if (normals[*it] == Vec3{}) continue;
      const auto surface = projector.surface_at(*it);
      if (!surface) continue;
      result.positions[*it - begin] = positions[*it] + options.radius * surface->foot();
      result.normals[*it - begin] = surface->normal_at_foot();
      result.moved[*it - begin] = 1;
    }
  });
  return result;
}

}  // namespace orbweave
