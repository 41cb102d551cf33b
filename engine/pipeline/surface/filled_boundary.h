// The boundary that is left when holes are filled, and the facts of the mesh that follow.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/mend_solids.h"
#include "engine/holes/problem/boundary_loop.h"
#include "engine/pipeline/surface/filled_holes.h"
#include "engine/stitching/chunk_mesh.h"

namespace orbweave {

/// The mesh before the fill, as far as its facts depend on it.
struct UnfilledMesh {
  std::vector<OpenFan> fans;                 ///< of pieces that are kept
  std::span<const ChunkPiece> pieces;        ///< all of the stitched mesh
  std::span<const std::uint8_t> is_removed;  ///< per piece
  const Mended& mended;
};

/// All patches together.
struct PatchTotals {
  double area = 0.0;  ///< square world units
  /// Of patches that do not close their loops whole; new vertices are kNewVertex + index over all
  /// batches.
  std::vector<Triangle64> open_triangles;
  /// Likewise, of patches that close their loops and touch several pieces of the mesh. Where such a
  /// loop touches itself its parts may leave the pieces apart.
  std::vector<Triangle64> joining_triangles;
  /// Likewise, of patches that mended closed objects.
  std::vector<Triangle64> mended_triangles;
};

/// The facts of the filled mesh. `facts`: of the stitched mesh, its area already without the pieces
/// that are removed. `loops`: by the ids of `filled.holes`.
MeshFacts facts_after_fill(MeshFacts facts, UnfilledMesh mesh, std::vector<BoundaryLoop> loops,
                           const FilledHoles& filled, const PatchTotals& patches);

}  // namespace orbweave
