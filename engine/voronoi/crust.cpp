#include "engine/voronoi/crust.h"

#include <algorithm>
#include <cmath>

#include "engine/voronoi/facet_links.h"
#include "engine/voronoi/facets.h"
#include "engine/voronoi/outside_walk.h"
#include "engine/voronoi/pruning.h"
#include "io/vec3_order.h"

namespace orbweave::voronoi {
namespace {

/// Whether the triangle's normal is about that of its corners.
class NormalFilter {
 public:
  NormalFilter(std::span<const Vec3> points, const Poles& poles, double most_angle_rad)
      : points_(points),
        poles_(poles),
        least_cosine_(std::cos(most_angle_rad)),
        least_cosine_elsewhere_(std::cos(1.5 * most_angle_rad)) {}

  bool keeps(const Triangle& t) const {
    const Vec3 normal =
        normalized(cross(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]));
    const std::size_t largest = largest_angle(t);
    for (std::size_t k = 0; k < 3; ++k) {
      const double cosine = std::abs(dot(normal, poles_.normals[t[k]]));
      if (cosine < (k == largest ? least_cosine_ : least_cosine_elsewhere_)) return false;
    }
    return true;
  }

 private:
  /// The corner opposite the longest side.
  std::size_t largest_angle(const Triangle& t) const {
    std::array<double, 3> opposite{};
    for (std::size_t k = 0; k < 3; ++k)
      opposite[k] = squared_norm(points_[t[(k + 1) % 3]] - points_[t[(k + 2) % 3]]);
    return static_cast<std::size_t>(std::max_element(opposite.begin(), opposite.end()) -
                                    opposite.begin());
  }

  std::span<const Vec3> points_;
  const Poles& poles_;
  double least_cosine_;
  double least_cosine_elsewhere_;
};

bool is_among(const Triangle& t, std::size_t points) {
  return t[0] < points && t[1] < points && t[2] < points;
}

}  // namespace

std::vector<Vec3> points_and_poles(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                   const Poles& poles) {
  std::vector<Vec3> both;
  for (const auto* list : {&poles.first, &poles.second})
    for (const std::uint32_t cell : *list)
      if (cell != kNone && tetrahedra.is_finite(cell)) both.push_back(tetrahedra.centers[cell]);
  std::erase_if(both, [](const Vec3& p) { return !is_finite(p); });
  std::sort(both.begin(), both.end(), comes_before);
  both.erase(std::unique(both.begin(), both.end()), both.end());
  both.insert(both.begin(), points.begin(), points.end());
  return both;
}

std::vector<Triangle> crust_triangles(std::span<const Vec3> points, std::span<const Vec3> both,
                                      const Tetrahedra& crust, const Poles& poles,
                                      const CrustOptions& options, const StopToken* stop) {
  const NormalFilter filter(points, poles, options.most_normal_angle_rad);
  FacetFlags flags(crust);
  for (std::uint32_t c = 0; c < crust.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    for (int place = 0; place < 4; ++place) {
      if (crust.neighbors[c][static_cast<std::size_t>(place)] < c) continue;
      const Triangle corners = corners_of(crust, {c, place});
      if (is_among(corners, points.size()) && (!options.filters || filter.keeps(corners)))
        flags.set({c, place});
    }
  }
  if (!options.extracts_manifold) return all_triangles(crust, flags);
  StarFinder stars(crust, both.size());
  FacetLinks links(both, crust, flags, stop);
  prune_sharp_edges(points, crust, stars, poles.normals, flags, links, stop);
  return walk_outside(points, crust, stars, poles.normals, flags, links, {}, stop);
}

}  // namespace orbweave::voronoi
