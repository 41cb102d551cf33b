#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>

#include "engine/voronoi/delaunay.h"
#include "engine/voronoi/triangulation.inl"

namespace orbweave::voronoi {
namespace {

using Vertex =
    CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel,
                                                CGAL::Regular_triangulation_vertex_base_3<Kernel>>;
using Cell =
    CGAL::Triangulation_cell_base_with_info_3<std::uint32_t, Kernel,
                                              CGAL::Regular_triangulation_cell_base_3<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_3<Vertex, Cell>;
using Regular = CGAL::Regular_triangulation_3<Kernel, Structure>;

Regular insert(std::span<const Vec3> positions, std::span<const double> weights,
               const StopToken* stop, const ShareDone& done) {
  const std::vector<Point> points = cgal_points(positions);
  Regular triangulation;
  Regular::Cell_handle near;
  std::size_t inserted = 0;
  for (const std::size_t i : insertion_order(points)) {
    look_up(inserted++, points.size(), stop, done);
    const Regular::Weighted_point point(points[i], weights[i]);
    Regular::Locate_type place;
    int li = 0, lj = 0;
    near = triangulation.locate(point, place, li, lj, near);
    const Regular::Vertex_handle vertex = triangulation.insert(point, place, near, li, lj);
    // A ball that has no cell changes nothing: the place that was found is still there.
    if (vertex == nullptr) continue;
    vertex->info() = static_cast<std::uint32_t>(i);
    near = vertex->cell();
  }
  return triangulation;
}

}  // namespace

Tetrahedra regular_triangulation(std::span<const Vec3> points, std::span<const double> weights,
                                 const StopToken* stop, const ShareDone& done) {
  Tetrahedra tetrahedra;
  {
    Regular triangulation = insert(points, weights, stop, done);
    require_dimension(triangulation.dimension(), points.size());
    tetrahedra = read_out(triangulation, points.size(), stop);
  }
  add_centers(points, weights, stop, tetrahedra);
  return tetrahedra;
}

std::uint64_t count_regular(std::span<const Vec3> points, std::span<const double> weights) {
  return insert(points, weights, nullptr, {}).number_of_finite_cells();
}

}  // namespace orbweave::voronoi
