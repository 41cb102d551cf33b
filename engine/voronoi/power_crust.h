// The Power Crust: the faces between the inner and the outer balls of the medial axis.
// Amenta, Choi, Kolluri, The Power Crust, 2001.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/poles.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

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

/// A ball of the medial axis.
struct MedialBall {
  Vec3 center;
  double radius = 0.0;
  std::uint32_t sample = 0;  ///< a point that the ball touches
};

/// Balls of the poles, each place once, in the order of their coordinates.
struct PolarBalls {
  std::vector<MedialBall> balls;
  std::vector<std::uint8_t> outer;  ///< known to be outside: the cell has a bounding point
  /// Balls of the two poles of each point; kNone: none.
  std::vector<std::uint32_t> first, second;
  /// Per point: minus the cosine of the angle between the directions to its two poles, at least 0.
  std::vector<double> opposite_weight;

  std::vector<Vec3> centers() const;
  std::vector<double> weights() const;  ///< squared radii
};

/// The points followed by the eight corners of the bounding box.
std::vector<Vec3> bounded_points(std::span<const Vec3> points, const PowerCrustOptions& options);

/// `tetrahedra`: the Delaunay triangulation of `bounded`.
PolarBalls polar_balls(std::span<const Vec3> bounded, const Tetrahedra& tetrahedra,
                       const PowerCrustOptions& options, const StopToken* stop = nullptr);

struct PowerCrustSurface {
  std::vector<Vec3> vertices;          ///< sorted by coordinates, each place once
  std::vector<std::uint32_t> samples;  ///< of each vertex: the point of the nearest pole
  /// Corners of all polygons, counter-clockwise seen from outside; a polygon ends where the next
  /// begins. Convex and plane, but for rounding.
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> polygon_begin;  ///< and the number of corners
  std::vector<MedialBall> medial_axis;       ///< the inner balls

  std::size_t polygons() const { return polygon_begin.size() - 1; }
};

/// `power`: the regular triangulation of the balls. Every edge has an even number of polygons.
PowerCrustSurface power_crust_surface(const PolarBalls& balls, const Tetrahedra& power,
                                      const StopToken* stop = nullptr);

/// The polygons in fans of triangles around their smallest corners. Smallest corner first, sorted.
std::vector<Triangle> triangles_of(const PowerCrustSurface& surface);

}  // namespace orbweave::voronoi
