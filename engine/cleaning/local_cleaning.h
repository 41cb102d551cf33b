// Projection and thinning that reach differently far from place to place.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/cleaning/projection.h"
#include "engine/cleaning/thinning.h"
#include "io/vec3.h"

namespace orbweave {

/// Points and the levels that decide how far cleaning reaches there.
struct LeveledPoints {
  std::span<const Vec3> positions;
  std::span<const Vec3> normals;  ///< empty: no sheets are told apart
  std::uint32_t begin = 0;        ///< the points asked for
  std::uint32_t end = 0;
  std::span<const std::uint8_t> levels;  ///< of every point; nothing is done to those at level 0
};

/// Margin that a chunk needs around its points: that of the largest radius.
double local_projection_halo(std::span<const double> radii, const ProjectionOptions& options);

/// As project_points(), each point with the radius of its level; the radius of `options` does not
/// count. All points count as neighbours. Points at level 0 are left as given, to the bit.
ProjectedPoints project_locally(const LeveledPoints& points, std::span<const double> radii,
                                const ProjectionOptions& options,
                                std::span<const std::uint8_t> chosen = {});

/// Margin that a chunk needs around its points: each level waits for those below.
double local_thinning_halo(std::span<const double> spacings);

/// As thin_points(), with the spacing of each level, ascending; the spacing of `options` does not
/// count. Points at level 0 are kept. Every level is decided after those below, whose kept points
/// leave room around them for none that is closer than its own spacing.
std::vector<std::uint8_t> thin_locally(const LeveledPoints& points,
                                       std::span<const double> spacings,
                                       const ThinningOptions& options);

}  // namespace orbweave
