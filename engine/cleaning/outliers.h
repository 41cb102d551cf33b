// Points that lie alone: statistical outliers, judged against their own neighbourhood.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

struct OutlierOptions {
  double sigma = 3.0;               ///< deviations that are still tolerated, positive
  std::size_t neighbors = 16;       ///< the point itself not counted
  double max_radius = 0.0;          ///< neighbours farther away do not count; world units
  const StopToken* stop = nullptr;  ///< looked at every few thousand points; may be null
};

/// Margin that a chunk needs around its points.
double outlier_halo(const OutlierOptions& options);

/// 1 for each of positions [begin, end) whose mean distance to its neighbours exceeds the mean of
/// the same figure over these neighbours by more than sigma of its deviations (taken as at least
/// 0.15 of the mean), or that has fewer than three neighbours. A neighbour that is missing within
/// the radius counts as lying at it. Positions must be distinct, finite and in canonical order and
/// reach as far as the halo; the result then does not depend on what else they hold. Runs on the
/// calling TBB arena.
std::vector<std::uint8_t> find_outliers(std::span<const Vec3> positions, std::uint32_t begin,
                                        std::uint32_t end, const OutlierOptions& options);

}  // namespace orbweave
