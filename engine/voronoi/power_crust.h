// The Power Crust: the faces between the inner and the outer balls of the medial axis.
// Amenta, Choi, Kolluri, The Power Crust, 2001.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/medial_balls.h"
#include "engine/voronoi/power_faces.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

struct PowerCrustOptions {
  /// The box of the bounding points in boxes of the points.
  double bounding_factor = 5.0;
  /// The published sampling constant r: distances between neighbours are at most r times their
  /// distance to the medial axis. A second pole nearer to its point than (1 - r) / r times the
  /// radius of the Voronoi cell across its normal cannot be on the medial axis, and is left out:
  /// such cells lie at creases and in noise. 1 leaves none out.
  double sampling_constant = 0.6;
};

/// The points followed by the eight corners of the bounding box.
std::vector<Vec3> bounded_points(std::span<const Vec3> points, const PowerCrustOptions& options);

/// `tetrahedra`: the Delaunay triangulation of `bounded`.
PolarBalls polar_balls(std::span<const Vec3> bounded, const Tetrahedra& tetrahedra,
                       const PowerCrustOptions& options, const StopToken* stop = nullptr);

/// `points`: those that the balls touch. `power`: the regular triangulation of the balls. Every
/// edge has two polygons, one in either direction; so it has two triangles where the polygons are
/// cut into triangles.
PowerCrustSurface power_crust_surface(std::span<const Vec3> points, const PolarBalls& balls,
                                      const Tetrahedra& power, const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
