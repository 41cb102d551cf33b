// On which side of the ball that is orthogonal to four balls a fifth one lies.
#pragma once

#include <array>

#include "engine/voronoi/weighted_vec.h"

namespace orbweave::voronoi {

/// The sign of the power test where it is certain, and 0 where it is not: 1 where the fifth ball is
/// in conflict with the first four, which are positively oriented, -1 where it is not. Doubles
/// decide where the bound of their error allows it, then pairs of doubles. Pairs of doubles tell
/// apart what differs by rounding alone: balls through one common point are degenerate but for the
/// rounding of their centres and weights, and so are the balls of a medial axis. Balls that are
/// exactly degenerate, and numbers near the ends of the range of doubles, are never certain.
int certain_power_sign(const std::array<WeightedVec, 5>& balls);

}  // namespace orbweave::voronoi
