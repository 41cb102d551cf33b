// The reconstruction methods of the Voronoi family, from points to surfaces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/certified_cells.h"
#include "engine/voronoi/crust.h"
#include "engine/voronoi/power_crust.h"
#include "engine/voronoi/share_done.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave::voronoi {

/// A surface whose vertices are the points.
struct PointSurface {
  std::vector<Triangle> triangles;         ///< smallest corner first, sorted
  std::vector<std::uint8_t> well_sampled;  ///< per point; empty where the method does not ask
};

struct CoconeOptions {
  double angle_rad = 0.39269908169872414;  ///< pi / 8, the published angle
  /// Pruning of sharp edges and the walk along the outside. Without it: all triangles.
  bool extracts_manifold = true;
  bool leaves_boundaries = true;  ///< as Dey and Giesen do it: open surfaces stay open
};

/// Points are in canonical order, no two at one place; fewer than 2^32. The results depend on the
/// points alone, not on the machine's threads. Throw Error: bad input where the points lie in one
/// plane, interrupted when `stop` is requested. `done` hears of the share of the work that is done,
/// every thousand points of a triangulation.
PointSurface cocone(std::span<const Vec3> points, const CoconeOptions& options = {},
                    const StopToken* stop = nullptr, const ShareDone& done = {});
/// The Cocone of a part of a cloud, and which of its Voronoi cells are the cloud's.
struct CoconePart {
  PointSurface surface;
  std::vector<std::uint8_t> certified;  ///< per point
};
/// `outward`: normals of the points; empty: not known. A part is open where it was cut, and the
/// walk along the outside needs to be told which side that is. Points of one plane have a surface
/// as well, of which nothing is certified. Throws Error: bad input where they lie on one line.
CoconePart cocone_of_part(std::span<const Vec3> points, std::span<const Vec3> outward,
                          const KnownPart& part, const StopToken* stop = nullptr);
PointSurface tight_cocone(std::span<const Vec3> points, const StopToken* stop = nullptr,
                          const ShareDone& done = {});
PointSurface crust(std::span<const Vec3> points, const CrustOptions& options = {},
                   const StopToken* stop = nullptr, const ShareDone& done = {});
PowerCrustSurface power_crust(std::span<const Vec3> points, const PowerCrustOptions& options = {},
                              const StopToken* stop = nullptr, const ShareDone& done = {});

/// The unit vectors from the points to their farther poles, without a consistent side. `done` hears
/// of the share that is triangulated.
std::vector<Vec3> pole_normals(std::span<const Vec3> points, const StopToken* stop = nullptr,
                               const ShareDone& done = {});

/// Processor seconds that the triangulations alone take which a method cannot do without, each made
/// anew by CGAL.
struct TriangulationSeconds {
  double points = 0.0;            ///< Delaunay, of the points
  double points_and_poles = 0.0;  ///< Delaunay
  double bounded_points = 0.0;    ///< Delaunay, of the points and eight corners
  double balls = 0.0;             ///< regular, of the weighted poles
  double points_here = 0.0;       ///< Delaunay, of the points, as the methods make it
};
/// Without `with_balls`: those of Crust and the Cocone family alone, the other seconds are 0.
TriangulationSeconds time_triangulations(std::span<const Vec3> points, bool with_balls = true);

}  // namespace orbweave::voronoi
