// Pieces of the stitched mesh that are not kept: too small ones and crumbs.
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

/// Per piece, whether it has fewer triangles; `min_triangles`: least_triangles() of the mesh.
std::vector<std::uint8_t> small_pieces(std::span<const ChunkPiece> pieces,
                                       std::uint64_t min_triangles);

/// Finds the triangles of the pieces that are to be removed (`is_removed`, per piece). `area`: of
/// the whole mesh. The surface still has them all afterwards.
RemovedPieces find_removed(std::span<const ChunkPiece> pieces,
                           std::span<const std::uint8_t> is_removed, const Surface& surface,
                           double area);

}  // namespace orbweave
