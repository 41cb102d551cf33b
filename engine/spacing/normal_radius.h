// How far from a point the neighbours are looked for that its normal is estimated from.
#pragma once

#include <cstddef>

#include "engine/spacing/searched_sites.h"
#include "io/stop_token.h"

namespace orbweave {

/// World units; 0 where no distance between points is known.
double normal_radius(const SearchedSites& sites, std::size_t neighbors, const StopToken* stop);

}  // namespace orbweave
