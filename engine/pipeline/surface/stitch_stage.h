// What the chunks' meshes are together: counts, the boundary of the whole, and how much of it every
// chunk has. The leader puts it together from what the chunks say of their borders and leaves it in
// the store; everybody else, and a run that was interrupted later, reads it there.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/pipeline/surface/surface_inputs.h"
#include "engine/stitching/mesh_summary.h"

namespace orbweave {

struct Stitched {
  MeshFacts facts;                       ///< counts and area; the exporter adds the rest
  StitchedBoundary boundary;             ///< nothing where no holes are filled
  std::vector<std::uint64_t> triangles;  ///< per chunk
  std::vector<std::uint32_t> used;       ///< points, as append_used_counts counts them
  std::uint64_t conflicts_lost = 0;
  std::uint64_t unused_points = 0;
  VoronoiFacts voronoi;
  SideFacts sides;
};

/// Looks at the borders of all chunks, one after the other. Throws Error (resource) where the
/// boundary does not fit the memory budget, before it is read, and says how much would do.
/// `advance` is called for every chunk.
Stitched stitch_chunks(
    const SurfaceInputs& inputs, const ResolvedJob& job, const ChunkStore& store,
    const StopToken& stop, const std::function<void()>& advance = [] {});

/// The stage. Throws as stitch_chunks, and Error (bad input) where no triangle was found.
Stitched stitch(const SurfaceInputs& inputs, StageRunner& runner);

/// What an earlier run left of the same mesh. Throws as stitch_chunks where it does not fit the
/// budget, before the boundary is read.
std::optional<Stitched> stored_stitch(const SurfaceInputs& inputs, const ResolvedJob& job,
                                      const ChunkStore& store);

}  // namespace orbweave
