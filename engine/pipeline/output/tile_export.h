// The mesh as tiles: a file per chunk with the chunk's triangles and all vertices that they use.
// Every vertex has the number that it has in the one mesh, so tiles can be joined exactly.
// docs/output.md has the files.
#pragma once

#include <cstdint>

#include "engine/pipeline/output/tile_input.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Throws Error (usage) where the job's mesh cannot be written as tiles.
void check_tile_format(const OutputOptions& output);

/// Throws Error (usage) where the tiles would replace what something else wrote.
void check_tile_place(const OutputOptions& output);

/// Writes the directory of tiles; every member of the team calls it. `digest` is the leader's.
/// Returns the bytes of the files.
std::uint64_t export_tiles(StageRunner& runner, StageClock& clock, const TileInput& input,
                           SurfaceDigest& digest);

}  // namespace orbweave
