#include <CGAL/Regular_triangulation_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>

#include "engine/voronoi/delaunay.h"
#include "engine/voronoi/power_side.h"
#include "engine/voronoi/triangulation.inl"

namespace orbweave::voronoi {
namespace {

/// CGAL's kernel, which asks its own predicate only where ours is not certain: intervals and exact
/// numbers take a third of the time of a triangulation of polar balls.
struct FilteredKernel : Kernel {
  struct Power_side_of_oriented_power_sphere_3 : Kernel::Power_side_of_oriented_power_sphere_3 {
    using Base = Kernel::Power_side_of_oriented_power_sphere_3;
    using Ball = Kernel::Weighted_point_3;
    using Base::operator();

    CGAL::Oriented_side operator()(const Ball& p, const Ball& q, const Ball& r, const Ball& s,
                                   const Ball& t) const {
      const int sign =
          certain_power_sign({weighted(p), weighted(q), weighted(r), weighted(s), weighted(t)});
      return sign == 0 ? Base::operator()(p, q, r, s, t) : static_cast<CGAL::Oriented_side>(sign);
    }

   private:
    static WeightedVec weighted(const Ball& p) { return {{p.x(), p.y(), p.z()}, p.weight()}; }
  };

  Power_side_of_oriented_power_sphere_3 power_side_of_oriented_power_sphere_3_object() const {
    return {};
  }
};

using Vertex = CGAL::Triangulation_vertex_base_with_info_3<
    std::uint32_t, FilteredKernel, CGAL::Regular_triangulation_vertex_base_3<FilteredKernel>>;
using Cell = CGAL::Triangulation_cell_base_with_info_3<
    std::uint32_t, FilteredKernel, CGAL::Regular_triangulation_cell_base_3<FilteredKernel>>;
using Regular = CGAL::Regular_triangulation_3<FilteredKernel,
                                              CGAL::Triangulation_data_structure_3<Vertex, Cell>>;

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
  using Plain = CGAL::Regular_triangulation_3<Kernel>;
  std::vector<Plain::Weighted_point> all;
  all.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    all.emplace_back(Point(points[i].x, points[i].y, points[i].z), weights[i]);
  return Plain(all.begin(), all.end()).number_of_finite_cells();
}

}  // namespace orbweave::voronoi
