// Hole stage: fills the boundary loops of the stitched mesh one by one, wherever they lie. Patches
// end in the chunk store, batches of loops in canonical order. What the patches do to the rest of
// the mesh (pieces removed, vertices doubled) is worked out from them.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/pipeline/stage/stage_runner.h"
#include "engine/pipeline/surface/filled_holes.h"
#include "engine/pipeline/surface/surface_inputs.h"
#include "engine/stitching/mesh_summary.h"

namespace orbweave {

struct HoleInputs {
  SurfaceInputs surface;
  StitchedBoundary boundary;
  MeshFacts facts;  ///< of the stitched mesh
};

struct HoleResult {
  FilledHoles filled;
  MeshFacts facts;                         ///< of the mesh that comes out
  std::uint64_t predicted_peak_bytes = 0;  ///< of the process in this stage
};

/// The stage. Batches that the store holds under the same options are not computed again.
HoleResult fill_holes(HoleInputs inputs, StageRunner& runner);

/// Pairs of triangles of the stitched mesh that cross, nothing filled.
std::uint64_t count_crossings_unfilled(const SurfaceInputs& inputs, StageRunner& runner);

/// The loops of a stitched mesh, nothing filled; `reason` says why where one would stay open.
std::vector<HoleFacts> list_loops(const StitchedBoundary& boundary, const FillOptions& options,
                                  const StopToken& stop);

}  // namespace orbweave
