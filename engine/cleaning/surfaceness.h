// How far the points around a point lie like a surface.
// Demantke, Mallet, David, Vallet: Dimensionality Based Scale Selection in 3D Lidar Point Clouds,
// 2011.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

struct SurfacenessOptions {
  std::size_t neighbors = 48;       ///< the point itself not counted
  double max_radius = 0.0;          ///< neighbours farther away do not count; world units
  const StopToken* stop = nullptr;  ///< looked at every few thousand points; may be null
};

/// Of positions [begin, end): with the deviations a >= b >= c of the neighbours along their
/// principal axes, (b - c) / a: 1 for a surface, 0 for a line or a cloud of leaves; an edge of a
/// box has 0.4, its corner 0. 1 where there are fewer than three neighbours: nothing is known.
/// Margin that a chunk needs: `max_radius`. Positions must be distinct, finite and in canonical
/// order. Runs on the calling TBB arena.
std::vector<float> surfaceness_of(std::span<const Vec3> positions, std::uint32_t begin,
                                  std::uint32_t end, const SurfacenessOptions& options);

}  // namespace orbweave
