#include "engine/voronoi/exact_signs.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/voronoi/power_side.h"
#include "io/vec3_order.h"

namespace orbweave::voronoi {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 exact(Vec3 p) { return {p.x, p.y, p.z}; }

/// Where p lies on the sphere of the corners.
int perturbed_sphere_side(const std::array<Vec3, 4>& corners, Vec3 p) {
  std::array<std::size_t, 4> order = {0, 1, 2, 3};
  std::sort(order.begin(), order.end(),
            [&](std::size_t i, std::size_t j) { return comes_before(corners[j], corners[i]); });
  for (const std::size_t greatest : order) {
    if (comes_before(corners[greatest], p)) return -1;
    // The corner outside makes room for p where p lies on its side of the other three.
    std::array<Vec3, 4> replaced = corners;
    replaced[greatest] = p;
    const int side = exact_plane_side(replaced);
    if (side != 0) return side;
  }
  return -1;
}

}  // namespace

double least_squared_error(std::span<const Vec3> points) {
  // A product that underflows is off by 2^-1074, times offsets and squares of at most 2^305.
  constexpr double kMostCoordinate = 0x1p100, kLeast = 0x1p-1000;
  const bool are_in_range = std::all_of(points.begin(), points.end(), [](const Vec3& p) {
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= kMostCoordinate;
  });
  return are_in_range ? kLeast : std::numeric_limits<double>::infinity();
}

int exact_plane_side(const std::array<Vec3, 4>& corners) {
  return static_cast<int>(CGAL::orientation(exact(corners[0]), exact(corners[1]), exact(corners[2]),
                                            exact(corners[3])));
}

int exact_sphere_side(const std::array<Vec3, 4>& corners, Vec3 p) {
  // Pairs of doubles nearly always tell, in less time, on which side of a sphere the points of a
  // round surface lie.
  int side = certain_power_sign(
      {{{corners[0], 0.0}, {corners[1], 0.0}, {corners[2], 0.0}, {corners[3], 0.0}, {p, 0.0}}});
  if (side == 0)
    side = static_cast<int>(CGAL::side_of_oriented_sphere(
        exact(corners[0]), exact(corners[1]), exact(corners[2]), exact(corners[3]), exact(p)));
  return side != 0 ? side : perturbed_sphere_side(corners, p);
}

}  // namespace orbweave::voronoi
