// The hole pass of a job: the boundary loops of the stitched mesh, filled one by one wherever they
// lie. Patches end in the chunk store, batches of loops in canonical order; what they do to the
// rest of the mesh (pieces removed, vertices doubled) is worked out from them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/pipeline/job_context.h"
#include "engine/pipeline/partition_stage.h"
#include "engine/pipeline/patch_batch.h"
#include "engine/stitching/mesh_summary.h"

namespace orbweave {

/// A corner of a triangle that is to use a copy of its vertex.
struct SplitCorner {
  Triangle64 triangle{};  ///< as stored; new vertices are kNewVertex + index over all batches
  std::uint64_t vertex = 0;
  std::uint64_t copy = 0;
  friend auto operator<=>(const SplitCorner&, const SplitCorner&) = default;
};

/// What the pass changes. Vertices are the job's, in canonical order.
struct FilledHoles {
  std::vector<HoleFacts> holes;              ///< all loops, in canonical order
  std::vector<std::uint64_t> new_vertices;   ///< per batch
  std::vector<std::uint64_t> new_triangles;  ///< per batch
  std::vector<Triangle64> removed;           ///< of pieces that are too small, sorted
  std::vector<std::uint64_t> freed;          ///< vertices that only they used, ascending
  std::vector<SplitCorner> splits;           ///< sorted
  std::vector<std::uint64_t> copies;         ///< per copy the vertex that it doubles
};

/// The stage. Brings `facts` up to date with the mesh that comes out. Batches that the store holds
/// under the same options are not computed again.
FilledHoles fill_holes(JobContext& context, const Partition& partition,
                       const std::vector<double>& radii, StitchedBoundary boundary,
                       MeshFacts& facts);

/// The loops of a stitched mesh, nothing filled; `reason` says why where one would stay open.
std::vector<HoleFacts> list_loops(const StitchedBoundary& boundary, const FillOptions& options);

/// The split of this corner; null where there is none.
const SplitCorner* find_split(const FilledHoles& holes, const Triangle64& triangle,
                              std::uint64_t vertex);

}  // namespace orbweave
