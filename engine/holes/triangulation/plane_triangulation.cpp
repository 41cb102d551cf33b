#include "engine/holes/triangulation/plane_triangulation.h"

#include <algorithm>

#include "engine/holes/triangulation/constrained_delaunay.h"

namespace orbweave {
namespace {

bool within_extent(PlanePoint p) {
  return std::max(p.x, p.y) <= kPlaneExtent && std::min(p.x, p.y) >= -kPlaneExtent;
}

}  // namespace

bool is_weakly_simple(std::span<const PlanePoint> polygon) {
  if (polygon.size() < 3 || !std::all_of(polygon.begin(), polygon.end(), within_extent)) {
    return false;
  }
  ConstrainedDelaunay delaunay(polygon, static_cast<std::uint32_t>(polygon.size()));
  return delaunay.insert_polygon() && delaunay.separate_corners();
}

std::vector<CornerTriangle> triangulate_polygon(std::span<const PlanePoint> points,
                                                std::uint32_t corners,
                                                const ForbiddenChord& is_forbidden) {
  if (corners < 3 || points.size() < corners ||
      !std::all_of(points.begin(), points.end(), within_extent)) {
    return {};
  }
  ConstrainedDelaunay delaunay(points, corners);
  if (!delaunay.insert_polygon()) return {};
  delaunay.insert_interior();
  if (!delaunay.separate_corners()) return {};
  if (is_forbidden) delaunay.avoid_chords(is_forbidden);
  return delaunay.inside();
}

}  // namespace orbweave
