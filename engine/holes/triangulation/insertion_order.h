// The order in which points enter a triangulation.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/triangulation/plane_point.h"

namespace orbweave {

/// Indices of points [first, last) in rounds of about doubling size, each along a Hilbert curve:
/// successive points are close, and none of the rounds sees an unfavourable order for long.
/// Amenta, Choi, Rote: Incremental Constructions con BRIO, SCG 2003. O(n log n).
std::vector<std::uint32_t> insertion_order(std::span<const PlanePoint> points, std::uint32_t first,
                                           std::uint32_t last);

}  // namespace orbweave
