// Every chunk's part of the mesh: its points with their halo through ball pivoting, stitched by
// ownership. The result of every chunk ends in the chunk store.
#pragma once

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/pipeline/surface/surface_inputs.h"

namespace orbweave {

/// The stage; its results are in the store. Chunks that the store holds already under the same
/// radii are not computed again.
void reconstruct_chunks(const SurfaceInputs& inputs, StageRunner& runner);

}  // namespace orbweave
