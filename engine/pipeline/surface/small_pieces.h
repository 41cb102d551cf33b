// Pieces of the stitched mesh that are too small to be kept.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/pipeline/surface/stored_surface.h"
#include "engine/stitching/chunk_mesh.h"

namespace orbweave {

/// What goes with the pieces.
struct RemovedPieces {
  std::vector<Triangle64> triangles;  ///< sorted
  std::vector<std::uint64_t> freed;   ///< vertices that only these triangles use, ascending
  double area_left = 0.0;             ///< of the mesh
};

/// Whether a piece is removed; `min_triangles`: least_triangles() of the mesh.
inline bool is_removed(const ChunkPiece& piece, std::uint64_t min_triangles) {
  return piece.triangles < min_triangles;
}

/// Finds the triangles of the pieces that are removed. `area`: of the whole mesh. The surface still
/// has them all afterwards.
RemovedPieces find_small_pieces(std::span<const ChunkPiece> pieces, std::uint64_t min_triangles,
                                const Surface& surface, double area);

}  // namespace orbweave
