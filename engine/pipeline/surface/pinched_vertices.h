// Vertices that are still pinched after the fill, doubled so that the mesh is manifold.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/pipeline/surface/filled_holes.h"
#include "engine/pipeline/surface/stored_surface.h"
#include "io/stop_token.h"

namespace orbweave {

struct SplitVertices {
  std::vector<SplitCorner> splits;    ///< sorted
  std::vector<std::uint64_t> copies;  ///< per copy the vertex that it doubles
};

/// Doubles the vertices of `pinched` (ascending) whose triangles, patches of the first `batches`
/// batches included, still have several fans. What is gathered at a time takes `memory_bytes`.
SplitVertices split_pinched(std::span<const std::uint64_t> pinched, const StoredSurface& surface,
                            const ChunkStore& store, ChunkId batches, std::size_t memory_bytes,
                            const StopToken& stop);

}  // namespace orbweave
