// Super Cocone: Cocone chunk by chunk, for clouds that are too large for one piece.
// Dey, Giesen, Hudson, Delaunay Based Shape Reconstruction from Large Data, 2001.
//
// Every chunk is computed from all points in a box around it, which grows once where a Voronoi cell
// of the chunk's points may be another one in the whole cloud. A triangle across chunks stays where
// the chunks of all its vertices have it, turned the same way. So every edge has at most two
// triangles, because it has so in the chunk of its first vertex.
#pragma once

#include "engine/pipeline/stage/stage_runner.h"
#include "engine/pipeline/surface/surface_inputs.h"

namespace orbweave {

/// Begins the stage of the cells, where it is not under the same key already. The root's alone,
/// before the stage of the mesh begins.
void begin_cells(const SurfaceInputs& inputs, StageRunner& runner);

/// The cells' stage and the mesh's; the results are in the store. Throws Error (resource) where a
/// chunk and what lies around it do not fit the memory budget.
void super_cocone(const SurfaceInputs& inputs, StageRunner& runner);

}  // namespace orbweave
