#include "engine/voronoi/delaunay.h"

#include <CGAL/Delaunay_triangulation_3.h>

#include "engine/voronoi/insertion.h"
#include "engine/voronoi/triangulation.inl"

namespace orbweave::voronoi {
namespace {

/// The first points, in an order, that do not lie in one plane: as many as there are, at most four.
std::vector<std::uint32_t> spanning_points(std::span<const Vec3> points,
                                           std::span<const std::size_t> order) {
  std::vector<std::uint32_t> spanning;
  const auto at = [&](std::size_t k) { return cgal_point(points[spanning[k]]); };
  for (const std::size_t i : order) {
    const Point p = cgal_point(points[i]);
    const bool is_new = spanning.empty() || (spanning.size() == 1 && p != at(0)) ||
                        (spanning.size() == 2 && !CGAL::collinear(at(0), at(1), p)) ||
                        (spanning.size() == 3 && !CGAL::coplanar(at(0), at(1), at(2), p));
    if (is_new) spanning.push_back(static_cast<std::uint32_t>(i));
    if (spanning.size() == 4) break;
  }
  return spanning;
}

/// Four points that do not lie in one plane. Throws where there are none.
std::array<std::uint32_t, 4> first_corners(std::span<const Vec3> points,
                                           std::span<const std::size_t> order) {
  const std::vector<std::uint32_t> spanning = spanning_points(points, order);
  require_dimension(static_cast<int>(spanning.size()) - 1, points.size());
  return {spanning[0], spanning[1], spanning[2], spanning[3]};
}

}  // namespace

Tetrahedra delaunay_without_centers(std::span<const Vec3> points, const StopToken* stop,
                                    const ShareDone& done) {
  const std::vector<std::size_t> order = insertion_order(cgal_points(points));
  Insertion insertion(points, first_corners(points, order));
  std::size_t inserted = 0;
  for (const std::size_t i : order) {
    look_up(inserted++, points.size(), stop, done);
    insertion.add(static_cast<std::uint32_t>(i));  // again: the first corners
  }
  return insertion.take(stop);
}

Tetrahedra delaunay(std::span<const Vec3> points, const StopToken* stop, const ShareDone& done) {
  Tetrahedra tetrahedra = delaunay_without_centers(points, stop, done);
  add_centers(points, {}, stop, tetrahedra);
  return tetrahedra;
}

void require_volume(std::span<const Vec3> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  first_corners(points, order);
}

std::uint64_t count_delaunay(std::span<const Vec3> points) {
  const std::vector<Point> all = cgal_points(points);
  return CGAL::Delaunay_triangulation_3<Kernel>(all.begin(), all.end()).number_of_finite_cells();
}

}  // namespace orbweave::voronoi
