// From the chunk store to the mesh file: vertices in canonical order, then triangles sorted by
// their vertices, both streamed; and the picture.
#pragma once

#include "engine/pipeline/job_context.h"
#include "engine/pipeline/partition_stage.h"
#include "engine/stitching/mesh_summary.h"

namespace orbweave {

/// Writes the mesh and returns its facts. Throws Error (bad input) where no triangle was found.
MeshFacts export_mesh(JobContext& context, const Partition& partition);

/// Draws the stored mesh to a PNG.
void draw_picture(JobContext& context, const Partition& partition);

}  // namespace orbweave
