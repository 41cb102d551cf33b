// The faces of a power diagram between inner and outer balls, as polygons.
// Amenta, Choi, Kolluri, The Power Crust, 2001, section 2.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/medial_balls.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave::voronoi {

struct PowerCrustSurface {
  /// Sorted by coordinates. Corners that have one place are one vertex, but where more than two
  /// polygons would meet at an edge for it.
  std::vector<Vec3> vertices;
  /// Of each vertex: the nearest of the points that the balls touch whose cells meet there.
  std::vector<std::uint32_t> samples;
  /// Corners of all polygons, counter-clockwise seen from outside; a polygon ends where the next
  /// begins. Convex and plane, but for rounding; no polygon has a corner twice.
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> polygon_begin;  ///< and the number of corners
  std::vector<MedialBall> medial_axis;       ///< the inner balls, sorted by centres

  std::size_t polygons() const { return polygon_begin.size() - 1; }
};

/// The surface without its medial axis. `points`: those that the balls touch. `power`: the regular
/// triangulation of the balls. `inner`: 1 for each ball that is inside, never for one whose cell
/// reaches infinity. O(n log n).
PowerCrustSurface faces_between(std::span<const Vec3> points, const PolarBalls& balls,
                                const Tetrahedra& power, std::span<const std::uint8_t> inner,
                                const StopToken* stop = nullptr);

/// The polygons in fans of triangles around their smallest corners. Smallest corner first, sorted.
std::vector<Triangle> triangles_of(const PowerCrustSurface& surface);

}  // namespace orbweave::voronoi
