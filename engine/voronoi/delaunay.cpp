#include "engine/voronoi/delaunay.h"

#include <CGAL/Delaunay_triangulation_3.h>

#include <utility>

#include "engine/voronoi/insertion.h"
#include "engine/voronoi/triangulation.inl"

namespace orbweave::voronoi {
namespace {

/// The first points that do not lie in one plane: as many as there are, at most four.
std::vector<std::uint32_t> spanning_points(std::span<const Vec3> points) {
  std::vector<std::uint32_t> spanning;
  const auto at = [&](std::size_t k) { return cgal_point(points[spanning[k]]); };
  for (std::uint32_t i = 0; i < points.size() && spanning.size() < 4; ++i) {
    const Point p = cgal_point(points[i]);
    const bool is_new = spanning.empty() || (spanning.size() == 1 && p != at(0)) ||
                        (spanning.size() == 2 && !CGAL::collinear(at(0), at(1), p)) ||
                        (spanning.size() == 3 && !CGAL::coplanar(at(0), at(1), at(2), p));
    if (is_new) spanning.push_back(i);
  }
  return spanning;
}

/// Four points that do not lie in one plane. Throws where there are none.
std::array<std::uint32_t, 4> first_corners(std::span<const Vec3> points) {
  const std::vector<std::uint32_t> spanning = spanning_points(points);
  require_dimension(static_cast<int>(spanning.size()) - 1, points.size());
  return {spanning[0], spanning[1], spanning[2], spanning[3]};
}

}  // namespace

Tetrahedra delaunay_without_centers(std::span<const Vec3> points, const StopToken* stop,
                                    const ShareDone& done) {
  std::vector<std::uint32_t> order;
  for (const std::size_t i : insertion_order(cgal_points(points)))
    order.push_back(static_cast<std::uint32_t>(i));
  std::vector<Vec3> in_order;
  in_order.reserve(points.size() + 1);
  for (const std::uint32_t i : order) in_order.push_back(points[i]);
  const std::array<std::uint32_t, 4> first = first_corners(in_order);
  Insertion insertion(std::move(in_order), first);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    look_up(i, points.size(), stop, done);
    insertion.add(i);
  }
  return insertion.take(order, stop);
}

Tetrahedra delaunay(std::span<const Vec3> points, const StopToken* stop, const ShareDone& done) {
  Tetrahedra tetrahedra = delaunay_without_centers(points, stop, done);
  add_centers(points, {}, stop, tetrahedra);
  return tetrahedra;
}

void require_volume(std::span<const Vec3> points) { first_corners(points); }

bool lie_in_one_plane(std::span<const Vec3> points) { return spanning_points(points).size() == 3; }

std::uint64_t count_delaunay(std::span<const Vec3> points) {
  const std::vector<Point> all = cgal_points(points);
  return CGAL::Delaunay_triangulation_3<Kernel>(all.begin(), all.end()).number_of_finite_cells();
}

}  // namespace orbweave::voronoi
