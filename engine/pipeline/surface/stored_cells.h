// What the chunks of a Super Cocone find, in the chunk store, until all have agreed.
#pragma once

#include <cstdint>
#include <vector>

#include "io/mesh_facts.h"
#include "io/store/chunk_store.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Triangles by global numbers: smallest first, sorted.
struct ChunkCells {
  std::vector<Triangle64> inner;           ///< whose vertices the chunk owns
  std::vector<Triangle64> seam;            ///< of which it owns some
  std::vector<std::uint8_t> undersampled;  ///< per own point
  VoronoiFacts facts;                      ///< contested triangles are not counted yet
};

void commit_cells(ChunkStore& store, ChunkId chunk, const ChunkCells& cells);
ChunkCells load_cells(const ChunkStore& store, ChunkId chunk);
std::vector<Triangle64> load_inner_triangles(const ChunkStore& store, ChunkId chunk);
std::vector<Triangle64> load_seam_triangles(const ChunkStore& store, ChunkId chunk);

}  // namespace orbweave
