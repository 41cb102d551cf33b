// How far from a point the neighbours are looked for that its normal is estimated from.
#pragma once

#include <cstddef>

#include "engine/spacing/automatic_radii.h"
#include "io/stop_token.h"

namespace orbweave {

/// World units; 0 where no distance between points is known.
double normal_radius(const SpacingSampler& sampler, std::size_t neighbors, const StopToken* stop);

}  // namespace orbweave
