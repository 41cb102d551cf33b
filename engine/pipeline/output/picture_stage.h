// The picture of the mesh, drawn from the chunk store.
#pragma once

#include "engine/pipeline/output/export_stage.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Picture stage: draws the stored mesh to a PNG, patches in their own colour. `bounds`: those of
/// the mesh, which the picture is fitted to. Reads every chunk once for its triangles and, for each
/// million vertices of rims, once more for their positions; as often again for every other side
/// that it looks from.
void draw_picture(const ExportInputs& inputs, const Box& bounds, StageRunner& runner);

}  // namespace orbweave
