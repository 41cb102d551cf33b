// The Crust: Delaunay triangles of points and poles whose corners are points.
// Amenta, Bern, Kamvysselis, A New Voronoi-Based Surface Reconstruction Algorithm, 1998.
#pragma once

#include <span>
#include <vector>

#include "engine/voronoi/poles.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave::voronoi {

struct CrustOptions {
  /// Largest angle between a triangle's normal and the direction to the pole at its corner of the
  /// largest angle; at the other corners one and a half times as much. The paper leaves the number
  /// to the user.
  double most_normal_angle_rad = 1.0471975511965976;  // 60 degrees
  bool filters = true;                                ///< by the angle to the poles
  /// Pruning of sharp edges and the walk along the outside, which make a manifold of the triangles.
  bool extracts_manifold = false;
};

/// The points followed by their poles: what Crust triangulates. Poles at infinity are left out,
/// each place is there once, and poles are in the order of their coordinates.
std::vector<Vec3> points_and_poles(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                   const Poles& poles);

/// The triangles of `crust`, the Delaunay triangulation of `both` = points_and_poles(...), among
/// the points. Smallest corner first, sorted; oriented outward by the extraction, by chance without
/// it.
std::vector<Triangle> crust_triangles(std::span<const Vec3> points, std::span<const Vec3> both,
                                      const Tetrahedra& crust, const Poles& poles,
                                      const CrustOptions& options, const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
