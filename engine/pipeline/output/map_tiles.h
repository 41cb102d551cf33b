// The mesh as tiles on a map grid: a file per square cell with the triangles whose centroid is in
// the cell, and all vertices that they use. The files depend on the mesh and the size of the cells
// alone. docs/output.md has the files.
#pragma once

#include <cstdint>

#include "engine/pipeline/output/tile_input.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Throws Error (usage) where the job has cells without tiles.
void check_tile_size(const Job& job);

/// Writes the directory of tiles; every member of the team calls it, the leader does it. `digest`
/// is the leader's. Returns the bytes of the files.
std::uint64_t export_map_tiles(StageRunner& runner, const TileInput& input, SurfaceDigest& digest);

}  // namespace orbweave
