// Points moved onto the surface that their neighbours suggest: moving least squares.
// Levin: Mesh-Independent Surface Interpolation, 2003; Alexa et al.: Computing and Rendering Point
// Set Surfaces, 2003.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/vec3.h"

namespace orbweave {

struct ProjectionOptions {
  double radius = 0.0;  ///< neighbours within it count, with Gaussian weights; world units
  /// Normals are oriented: neighbours count by how far theirs agree. Otherwise both signs agree.
  bool oriented = true;
};

struct ProjectedPoints {
  std::vector<Vec3> positions;      ///< of points [begin, end)
  std::vector<Vec3> normals;        ///< unit; on the side of the given ones
  std::vector<std::uint8_t> moved;  ///< 0 where there were too few neighbours: as given
};

/// One projection of positions [begin, end); the halo is options.radius. Normals are unit, zero
/// where unknown (such a point stays). Positions must be finite and in the same order for every
/// partition; sums run in that order. Positions need not be distinct. Runs on the calling TBB
/// arena.
ProjectedPoints project_points(std::span<const Vec3> positions, std::span<const Vec3> normals,
                               std::uint32_t begin, std::uint32_t end,
                               const ProjectionOptions& options);

}  // namespace orbweave
