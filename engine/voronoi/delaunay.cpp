#include "engine/voronoi/delaunay.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>

#include "engine/voronoi/triangulation.inl"

namespace orbweave::voronoi {
namespace {

using Vertex = CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>;
using Cell =
    CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel,
                                              CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_3<Vertex, Cell>;
using Delaunay = CGAL::Delaunay_triangulation_3<Kernel, Structure>;

Delaunay insert(std::span<const Vec3> positions, const StopToken* stop, const ShareDone& done) {
  const std::vector<Point> points = cgal_points(positions);
  Delaunay triangulation;
  Delaunay::Vertex_handle last;
  std::size_t inserted = 0;
  for (const std::size_t i : insertion_order(points)) {
    look_up(inserted++, points.size(), stop, done);
    const std::size_t before = triangulation.number_of_vertices();
    last =
        triangulation.insert(points[i], last == nullptr ? Delaunay::Cell_handle() : last->cell());
    const auto index = static_cast<std::uint32_t>(i);
    const bool is_new = triangulation.number_of_vertices() != before;
    last->info() = is_new ? index : std::min(last->info(), index);
  }
  return triangulation;
}

}  // namespace

Tetrahedra delaunay_without_centers(std::span<const Vec3> points, const StopToken* stop,
                                    const ShareDone& done) {
  Delaunay triangulation = insert(points, stop, done);
  require_dimension(triangulation.dimension(), points.size());
  return read_out(triangulation, points.size(), stop);
}

Tetrahedra delaunay(std::span<const Vec3> points, const StopToken* stop, const ShareDone& done) {
  Tetrahedra tetrahedra = delaunay_without_centers(points, stop, done);
  add_centers(points, {}, stop, tetrahedra);
  return tetrahedra;
}

void require_volume(std::span<const Vec3> points) {
  std::vector<Point> spanning;
  for (const Vec3 position : points) {
    const Point p(position.x, position.y, position.z);
    const bool is_new =
        spanning.empty() || (spanning.size() == 1 && p != spanning[0]) ||
        (spanning.size() == 2 && !CGAL::collinear(spanning[0], spanning[1], p)) ||
        (spanning.size() == 3 && !CGAL::coplanar(spanning[0], spanning[1], spanning[2], p));
    if (is_new) spanning.push_back(p);
    if (spanning.size() == 4) return;
  }
  require_dimension(static_cast<int>(spanning.size()) - 1, points.size());
}

std::uint64_t count_delaunay(std::span<const Vec3> points) {
  const std::vector<Point> all = cgal_points(points);
  return CGAL::Delaunay_triangulation_3<Kernel>(all.begin(), all.end()).number_of_finite_cells();
}

}  // namespace orbweave::voronoi
