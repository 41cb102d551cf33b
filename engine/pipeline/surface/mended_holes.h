// Closed objects of a job, mended once their holes are filled and checked.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/mend_solids.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/pipeline/surface/stored_surface.h"
#include "engine/pipeline/surface/surface_inputs.h"

namespace orbweave {

struct MendInputs {
  const SurfaceInputs& surface;
  const StoredSurface& mesh;  ///< without the pieces that are removed
  const HolePlan& plan;
  ChunkId batches = 0;                     ///< of patches, settled
  std::span<const OpenFan> fans;           ///< of the mesh before the fill, sorted by vertex
  std::span<const std::uint64_t> pinched;  ///< vertices with several fans before the fill
};

/// What mend_solids() makes of the patches in the store. The same in every process.
Mended mend_holes(const MendInputs& inputs, StageRunner& runner);

/// Takes replaced patches out of the stored batches, and adds the new ones as one more batch. Only
/// the root calls it.
void store_mended(const Mended& mended, const MendInputs& inputs, StageRunner& runner);

}  // namespace orbweave
