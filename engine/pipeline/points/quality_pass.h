// The quality of points as attributes that the mesh's vertices are to carry.
#pragma once

#include <span>

#include "engine/pipeline/points/noise_stage.h"
#include "engine/pipeline/points/raw_passes.h"
#include "io/vertex_quality.h"

namespace orbweave {

/// Adds the attributes of quality_fields() to the raw points: their spacing, the noise around them,
/// no move yet, and what decides the side of their normals. A scan's own attributes of these names
/// go. Of points without a scanner that `origin` needs, no side is known.
RawPass quality_pass(const RawCloud& cloud, const LocalCleaning& cleaning, NormalOrigin origin,
                     const StopToken& stop);

/// Adds the way from `points.positions` to `after` to the quality, where the points have one.
void add_moves(PointCloud& points, std::span<const Vec3> after);

}  // namespace orbweave
