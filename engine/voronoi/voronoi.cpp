#include "engine/voronoi/voronoi.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>

#include "engine/voronoi/cocone.h"
#include "engine/voronoi/delaunay.h"
#include "engine/voronoi/facet_links.h"
#include "engine/voronoi/facets.h"
#include "engine/voronoi/outside_walk.h"
#include "engine/voronoi/pruning.h"
#include "engine/voronoi/tight_cocone.h"
#include "io/bounds.h"

namespace orbweave::voronoi {
namespace {

/// What the methods of the Cocone family begin with.
struct Cells {
  Tetrahedra tetrahedra;
  Poles poles;
  std::vector<CenterSides> sides;  ///< of the published angle
  CoconeEdges edges;

  Cells(std::span<const Vec3> points, const StopToken* stop, const ShareDone& done)
      : tetrahedra(delaunay(points, stop, done)), poles(find_poles(points, tetrahedra, stop)) {}

  void measure(std::span<const Vec3> points, const StopToken* stop) {
    sides = center_sides(points, tetrahedra, poles, kCoconeAngleRad, stop);
    edges = cocone_edges(tetrahedra, sides, stop);
  }

  std::vector<std::uint8_t> flat(std::span<const Vec3> points, const StopToken* stop) const {
    return flat_points(points, tetrahedra, poles, sides, edges, {}, stop);
  }

  /// The facets for an angle of its own.
  FacetFlags facets(std::span<const Vec3> points, std::span<const std::uint8_t> choosing,
                    double angle_rad, const StopToken* stop) const {
    if (angle_rad == kCoconeAngleRad) return cocone_facets(tetrahedra, edges, choosing, stop);
    const auto own = center_sides(points, tetrahedra, poles, angle_rad, stop);
    return cocone_facets(tetrahedra, cocone_edges(tetrahedra, own, stop), choosing, stop);
  }
};

/// The progress of a part of some work as that of the whole.
ShareDone part_of(const ShareDone& done, double from, double to) {
  if (!done) return {};
  return [&done, from, to](double share) { done(from + (to - from) * share); };
}

void tell(const ShareDone& done, double share) {
  if (done) done(share);
}

template <class Work>
double seconds_of(const Work& work) {
  const std::clock_t begin = std::clock();
  work();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

/// From the cells on.
PointSurface cocone_of_cells(Cells& cells, std::span<const Vec3> points,
                             std::span<const Vec3> outward, const CoconeOptions& options,
                             const StopToken* stop, const ShareDone& done) {
  tell(done, kCellsOfCocone);
  cells.measure(points, stop);
  std::vector<std::uint8_t> flat = cells.flat(points, stop);
  FacetFlags facets =
      cells.facets(points, options.leaves_boundaries ? flat : std::vector<std::uint8_t>(),
                   options.angle_rad, stop);
  if (!options.extracts_manifold) return {all_triangles(cells.tetrahedra, facets), std::move(flat)};
  StarFinder stars(cells.tetrahedra, points.size());
  const std::vector<Vec3>& normals = cells.poles.normals;
  FacetLinks links(points, cells.tetrahedra, facets, stop);
  tell(done, kArraysOfCocone);
  prune_sharp_edges(points, cells.tetrahedra, stars, normals, facets, links, stop);
  return {walk_outside(points, cells.tetrahedra, stars, normals, facets, links, outward, stop),
          std::move(flat)};
}

}  // namespace

PointSurface cocone(std::span<const Vec3> points, const CoconeOptions& options,
                    const StopToken* stop, const ShareDone& done) {
  Cells cells(points, stop, part_of(done, 0.0, kCellsOfCocone));
  return cocone_of_cells(cells, points, {}, options, stop, done);
}

namespace {

/// A point on either side of the plane that the points lie in, far above the middle of them.
std::array<Vec3, 2> points_beside_plane(std::span<const Vec3> points) {
  const auto farther = [&](const auto& distance) {
    return *std::max_element(points.begin(), points.end(), [&](const Vec3& p, const Vec3& q) {
      return distance(p) < distance(q);
    });
  };
  const Vec3 a = points.front();
  const Vec3 b = farther([&](const Vec3& p) { return squared_norm(p - a); });
  const Vec3 c = farther([&](const Vec3& p) { return squared_norm(cross(b - a, p - a)); });
  const Vec3 normal = normalized(cross(b - a, c - a));
  const Box box = bounds_of(points);
  const Vec3 middle = box.center() - dot(box.center() - a, normal) * normal;
  constexpr double kDiagonals = 2.0;
  const Vec3 up = kDiagonals * box.diagonal() * normal;
  return {middle + up, middle - up};
}

/// Points of one plane have no tetrahedra. With one more on either side of it they have: facets
/// between these are the plane's own Delaunay triangles, but along its border.
CoconePart cocone_of_flat_part(std::span<const Vec3> points, std::span<const Vec3> outward,
                               const StopToken* stop) {
  std::vector<Vec3> all(points.begin(), points.end());
  const std::array<Vec3, 2> beside = points_beside_plane(points);
  all.insert(all.end(), beside.begin(), beside.end());
  std::vector<Vec3> normals(outward.begin(), outward.end());
  if (!normals.empty()) normals.resize(all.size());
  Cells cells(all, stop, {});
  CoconePart found;
  found.surface = cocone_of_cells(cells, all, normals, {}, stop, {});
  std::erase_if(found.surface.triangles, [&](const Triangle& t) {
    return std::max({t[0], t[1], t[2]}) >= points.size();
  });
  found.surface.well_sampled.resize(points.size());
  found.certified.assign(points.size(), 0);
  return found;
}

}  // namespace

CoconePart cocone_of_part(std::span<const Vec3> points, std::span<const Vec3> outward,
                          const KnownPart& part, const StopToken* stop) {
  if (lie_in_one_plane(points)) return cocone_of_flat_part(points, outward, stop);
  Cells cells(points, stop, {});
  CoconePart found;
  found.certified = certified_cells(points, cells.tetrahedra, part, stop);
  found.surface = cocone_of_cells(cells, points, outward, {}, stop, {});
  return found;
}

PointSurface tight_cocone(std::span<const Vec3> points, const StopToken* stop,
                          const ShareDone& done) {
  Cells cells(points, stop, part_of(done, 0.0, kCellsOfCocone));
  tell(done, kCellsOfCocone);
  cells.measure(points, stop);
  const FacetFlags facets = cells.facets(points, {}, kCoconeAngleRad, stop);
  std::vector<std::uint8_t> flat = cells.flat(points, stop);
  const Stars stars = stars_of(cells.tetrahedra, points.size());
  tell(done, kArraysOfCocone);
  std::vector<Triangle> triangles = tight_cocone(points, cells.tetrahedra, stars, cells.poles,
                                                 cells.sides, cells.edges, facets, flat, stop);
  return {std::move(triangles), std::move(flat)};
}

PointSurface crust(std::span<const Vec3> points, const CrustOptions& options, const StopToken* stop,
                   const ShareDone& done) {
  // Shares of the time as they are on scans.
  constexpr double kDelaunay = 0.2, kWithPoles = 0.85;
  std::vector<Vec3> both;
  Poles poles;
  {
    Cells cells(points, stop, part_of(done, 0.0, kDelaunay));
    both = points_and_poles(points, cells.tetrahedra, cells.poles);
    poles = std::move(cells.poles);
  }
  const ShareDone with_poles = part_of(done, kDelaunay, kWithPoles);
  const Tetrahedra all = options.extracts_manifold
                             ? delaunay(both, stop, with_poles)
                             : delaunay_without_centers(both, stop, with_poles);
  return {crust_triangles(points, both, all, poles, options, stop), {}};
}

PowerCrustSurface power_crust(std::span<const Vec3> points, const PowerCrustOptions& options,
                              const StopToken* stop, const ShareDone& done) {
  // Shares of the time as they are on scans.
  constexpr double kDelaunay = 0.15, kRegular = 0.9;
  require_volume(points);
  PolarBalls balls;
  {
    const std::vector<Vec3> bounded = bounded_points(points, options);
    balls =
        polar_balls(bounded, delaunay(bounded, stop, part_of(done, 0.0, kDelaunay)), options, stop);
  }
  const Tetrahedra power = regular_triangulation(balls.centers(), balls.weights(), stop,
                                                 part_of(done, kDelaunay, kRegular));
  return power_crust_surface(points, balls, power, stop);
}

std::vector<Vec3> pole_normals(std::span<const Vec3> points, const StopToken* stop,
                               const ShareDone& done) {
  const Tetrahedra tetrahedra = delaunay(points, stop, done);
  return find_poles(points, tetrahedra, stop).normals;
}

TriangulationSeconds time_triangulations(std::span<const Vec3> points, bool with_balls) {
  const PowerCrustOptions options;
  TriangulationSeconds seconds;
  seconds.points = seconds_of([&] { count_delaunay(points); });
  seconds.points_here = seconds_of([&] { delaunay_without_centers(points); });
  std::vector<Vec3> both;
  {
    const Cells cells(points, nullptr, {});
    both = points_and_poles(points, cells.tetrahedra, cells.poles);
  }
  seconds.points_and_poles = seconds_of([&] { count_delaunay(both); });
  if (!with_balls) return seconds;
  const std::vector<Vec3> bounded = bounded_points(points, options);
  seconds.bounded_points = seconds_of([&] { count_delaunay(bounded); });
  const PolarBalls balls = polar_balls(bounded, delaunay(bounded), options);
  const std::vector<Vec3> centers = balls.centers();
  const std::vector<double> weights = balls.weights();
  seconds.balls = seconds_of([&] { count_regular(centers, weights); });
  return seconds;
}

}  // namespace orbweave::voronoi
