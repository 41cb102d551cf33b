// Where a patch crosses itself or the sheet that it closes.
#pragma once

#include <cstdint>

#include "engine/holes/hole.h"

namespace orbweave {

/// Pairs of triangles that intersect (engine/holes/triangle_intersection.h), one of the patch and
/// another of the patch or of the gathered sheet; counting ends at `limit`. O(n log n) where few
/// boxes overlap.
std::uint64_t count_intersections(const HoleProblem& problem, const HolePatch& patch,
                                  std::uint64_t limit = UINT64_MAX);

}  // namespace orbweave
