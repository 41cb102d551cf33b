// Points moved onto the surface that their neighbours suggest: moving least squares.
// Levin: Mesh-Independent Surface Interpolation, 2003; Alexa et al.: Computing and Rendering Point
// Set Surfaces, 2003.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

struct ProjectionOptions {
  double radius = 0.0;  ///< neighbours within it count, the nearer the more; positive, world units
  /// Normals are oriented: neighbours count by how far theirs agree. Otherwise both signs agree.
  bool oriented = true;
  const StopToken* stop = nullptr;     ///< looked at every few dozen points; may be null
  std::string radius_name = "radius";  ///< what a message about the radius calls it
};

/// Side of the cubes of the lattice whose points may share a surface.
double shared_side(const ProjectionOptions& options);

/// Margin that a chunk needs around its points.
double projection_halo(const ProjectionOptions& options);

struct ProjectedPoints {
  std::vector<Vec3> positions;  ///< of points [begin, end)
  /// Unit, on the side of the given ones but where most neighbours' differ from those.
  std::vector<Vec3> normals;
  std::vector<std::uint8_t> moved;  ///< 0 where there were too few neighbours: as given
};

/// One projection of positions [begin, end) onto the plane or, where there are enough neighbours,
/// the quadratic height field that fits those around best. Points in a cube of half the radius
/// whose normals agree share the surface around their middle; the halo is that of projection_halo.
/// No point moves farther than the radius. Normals are unit, zero where unknown (such a point
/// stays, and counts for no other). Positions must be finite and in the same order for every
/// partition; sums run in that order. Positions need not be distinct. Points of [begin, end) whose
/// flag in `chosen` is 0 are left as given; empty: all are chosen. Throws Error (usage) for a
/// radius that makes neighbours of tens of thousands of points. Runs on the calling TBB arena.
ProjectedPoints project_points(std::span<const Vec3> positions, std::span<const Vec3> normals,
                               std::uint32_t begin, std::uint32_t end,
                               const ProjectionOptions& options,
                               std::span<const std::uint8_t> chosen = {});

/// The points [begin, end) as they are given, before any projection.
ProjectedPoints as_given(std::span<const Vec3> positions, std::span<const Vec3> normals,
                         std::uint32_t begin, std::uint32_t end);

/// As project_points(), but what becomes of the chosen points goes to `result`, which has a row for
/// each of [begin, end); others, and points that stay as given, are not written.
void project_chosen(std::span<const Vec3> positions, std::span<const Vec3> normals,
                    std::uint32_t begin, std::uint32_t end, const ProjectionOptions& options,
                    std::span<const std::uint8_t> chosen, ProjectedPoints& result);

}  // namespace orbweave
