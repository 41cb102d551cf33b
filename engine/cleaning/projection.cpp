#include "engine/cleaning/projection.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
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
/// Squared distance in radii that still counts: a hair less than the halo that chunks are cut with.
constexpr double kReach = 1.0 - 1e-12;

Vec3 vector_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

/// Projects the points of one cell of the grid after the other, a few of them at once.
class Projector {
 public:
  Projector(std::span<const Vec3> positions, std::span<const Vec3> normals,
            const ProjectionOptions& options, const NeighborGrid& grid)
      : positions_(positions), normals_(normals), options_(options), grid_(grid) {}

  /// Copies the points around a cell into columns.
  void enter(std::uint32_t cell) {
    grid_.gather(cell, cursor_, cells_, candidates_);
    around_.reserve(candidates_.size());
    for (NearPoints& near : near_) near.reserve(candidates_.size());
    const LaneColumns& to = around_.columns.points;
    std::uint32_t row = 0;
    for (const std::uint32_t i : candidates_) {
      const Vec3 p = positions_[i], n = normals_[i];
      to.x[row] = p.x;
      to.y[row] = p.y;
      to.z[row] = p.z;
      to.normal_x[row] = n.x;
      to.normal_y[row] = n.y;
      to.normal_z[row++] = n.z;
    }
    constexpr double kNowhere = std::numeric_limits<double>::infinity();
    std::fill_n(to.x + row, (4 - row % 4) % 4, kNowhere);
    around_.columns.count = row;
  }

  /// The local surfaces around at most kSurfacesAtOnce points of the cell.
  void surfaces_at(std::span<const std::uint32_t> points,
                   std::span<std::optional<LocalSurface>> surfaces) {
    std::array<SurfaceSamples, kSurfacesAtOnce> samples;
    for (std::size_t k = 0; k < points.size(); ++k) {
      NearColumns& near = near_[k].columns;
      const std::uint32_t point = points[k];
      kernel_.find_near(around_.columns.points, around_.columns.count, &positions_[point].x,
                        1.0 / options_.radius, kReach, near);
      const Vec3 reference = reference_normal(near, normals_[point]);
      samples[k] = {&near, kernel_.weigh(near, &reference.x, options_.oriented), reference};
    }
    fit_surfaces(std::span(samples).first(points.size()), surfaces);
  }

 private:
  /// The point's own normal, or what those around suggest where they do not support it: one
  /// estimated in the thick of layers may point anywhere.
  Vec3 reference_normal(const NearColumns& near, Vec3 own) const {
    AgreementSums sums = agreement(near, own);
    Vec3 reference = own;
    // Normals of either sign have no mean: there, the own one has to do.
    if (options_.oriented && sums.support < kSupport * sums.weight) {
      const Vec3 mean = vector_of(sums.normals);
      if (norm(mean) > kOneSheet * sums.weight) {
        reference = normalized(mean);
        sums = agreement(near, reference);
      }
    }
    for (int mean = 0;;) {
      const Vec3 sum = vector_of(sums.agreeing);
      if (squared_norm(sum) > 0.0) reference = normalized(sum);
      if (++mean == kMeans) return reference;
      sums = agreement(near, reference);
    }
  }

  AgreementSums agreement(const NearColumns& near, Vec3 reference) const {
    AgreementSums sums;
    kernel_.agreement(near, &reference.x, options_.oriented, kSupports, sums);
    return sums;
  }

  std::span<const Vec3> positions_, normals_;
  ProjectionOptions options_;
  const NeighborGrid& grid_;
  const SurfaceKernel& kernel_ = surface_kernel();
  NeighborGrid::Cursor cursor_;
  std::vector<std::uint32_t> cells_, candidates_;
  NearPoints around_;  // the candidates
  std::array<NearPoints, kSurfacesAtOnce> near_;
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
    std::array<std::uint32_t, kSurfacesAtOnce> points;
    std::array<std::optional<LocalSurface>, kSurfacesAtOnce> surfaces;
    for (auto it = first; it != last;) {
      check_stop(options.stop);
      std::size_t count = 0;
      for (; it != last && count < kSurfacesAtOnce; ++it)
        if (normals[*it] != Vec3{}) points[count++] = *it;
      projector.surfaces_at(std::span(points).first(count), surfaces);
      for (std::size_t k = 0; k < count; ++k) {
        if (!surfaces[k]) continue;
        const std::uint32_t point = points[k];
        result.positions[point - begin] = positions[point] + options.radius * surfaces[k]->foot();
        result.normals[point - begin] = surfaces[k]->normal_at_foot();
        result.moved[point - begin] = 1;
      }
    }
  });
  return result;
}

}  // namespace orbweave
