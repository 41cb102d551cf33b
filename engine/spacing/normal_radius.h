// How far from a point the neighbours are looked for that its normal is estimated from.
#pragma once

#include <cstddef>

#include "engine/spacing/sampled_neighbors.h"
#include "io/stop_token.h"

namespace orbweave {

/// World units; the sample has at least so many neighbours. 0 where no distance between points is
/// known.
double normal_radius(const SampledNeighbors& sample, std::size_t neighbors, const StopToken* stop);
/// The same, of a sample that may have fewer neighbours: fewer places are measured then.
double normal_radius(const SearchedSites& sites, const SampledNeighbors& sample,
                     std::size_t neighbors, const StopToken* stop);

}  // namespace orbweave
