// Levels of detail of the finished mesh file, as 3D Tiles.
#pragma once

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Throws Error (usage) where the job asks for a tileset that cannot be made: its mesh is no
/// uncompressed PLY file, the memory budget has no room for a tile, or something else than an
/// earlier tileset is there.
void check_tileset(const Job& job);

struct TilesetInputs {
  const Partition& partition;
  std::uint64_t triangles = 0;  ///< of the mesh file
};

/// Tileset stage: reads the finished mesh file and cuts it into tiles, by the root alone. The bytes
/// depend on the mesh file, its coordinate system and the upright axis alone. Simplified tiles are
/// kept in the store: a later run simplifies none of them again. Throws CorruptResult where one is
/// damaged.
void make_tileset(const TilesetInputs& inputs, StageRunner& runner);

}  // namespace orbweave
