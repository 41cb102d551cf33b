// Orientation where the scanner is unknown: patches chunk by chunk, then one graph of them all.
#pragma once

#include <memory>

#include "engine/normals/orientation.h"
#include "engine/pipeline/points/raw_passes.h"

namespace orbweave {

/// Computes patches and their signs under a rule that is_propagated. `spacing` is that of the
/// points as they are now. Members other than the leader get patches and their turns alone.
PatchOrientation orient_cloud(StageRunner& runner, const RawCloud& cloud, Orientation rule,
                              double spacing, double max_radius);

/// 1 for each of a chunk's points whose normal has to be turned.
std::vector<std::uint8_t> turns_of_chunk(const ChunkStore& store, ChunkId chunk,
                                         const PatchOrientation& orientation);

}  // namespace orbweave
