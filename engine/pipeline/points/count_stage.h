// Count stage: how many points lie where, and how they are cut into chunks.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/pipeline/points/cloud_input.h"
#include "engine/pipeline/points/cut_exchange.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Counts a cloud by one process, without a store. Where strays or missing returns turn up, the
/// pass is repeated without them. Throws Error (bad input) where there is no usable point.
CountedCloud count_points(const RunControl& control, const CloudInput& input);

/// The stage, by the whole team. Throws as count_points.
CountedCloud count_by_team(const CloudInput& input, const CutExchange& cut, StageRunner& runner);

/// True where the chunks of this cut are cleaned or get normals, and the points are then cut anew.
bool is_cut_again(const CloudInput& input);

/// Points of a chunk whose side is wide beside the halo of `radii`; at most `points`.
std::uint64_t worthwhile_points(const std::vector<double>& radii, double points_per_area,
                                std::uint64_t points);

}  // namespace orbweave
