// From the chunk store to the mesh file: vertices in canonical order, then triangles sorted by
// their vertices, then the patches of holes in their order, all streamed; and the picture.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/pipeline/hole_stage.h"
#include "engine/pipeline/job_context.h"
#include "engine/pipeline/partition_stage.h"
#include "engine/pipeline/used_vertices.h"

namespace orbweave {

/// Throws Error (usage) where the mesh of so many points is bound to be too large for its format; a
/// closed surface has twice as many triangles as vertices.
void check_format_holds(const OutputOptions& output, std::uint64_t points);

/// Writes the mesh; `triangles`: those that are stored, per chunk. `facts` gets bounds and
/// checksum.
void export_mesh(JobContext& context, const Partition& partition,
                 const std::vector<std::uint64_t>& triangles, const UsedVertices& used,
                 const FilledHoles& holes, MeshFacts& facts);

/// Draws the stored mesh to a PNG, patches in their own colour.
void draw_picture(JobContext& context, const Partition& partition, const FilledHoles& holes);

}  // namespace orbweave
