// The picture of the mesh, drawn from the chunk store.
#pragma once

#include "engine/pipeline/output/export_stage.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Picture stage: draws the stored mesh to a PNG, patches in their own colour. Reads every chunk
/// once for its triangles and, for each million vertices of rims, once more for their positions.
void draw_picture(const ExportInputs& inputs, StageRunner& runner);

}  // namespace orbweave
