// Every chunk's part of the mesh: its points with their halo through ball pivoting, stitched by
// ownership. The result of every chunk ends in the chunk store.
#pragma once

#include <string>
#include <vector>

#include "engine/pipeline/job_context.h"
#include "engine/pipeline/partition_stage.h"
#include "engine/stitching/chunk_mesh.h"

namespace orbweave {

inline constexpr const char* kMeshStage = "mesh";
/// Arrays of its results: Triangle in the chunk's own numbers (local_numbers.h), in the order of
/// the mesh; the vertices among them that others own.
inline constexpr const char* kStoredTriangles = "triangles";
inline constexpr const char* kStoredOuter = "outer_vertices";

void commit_chunk_mesh(ChunkStore& store, ChunkId chunk, const ChunkMesh& mesh);
/// Everything but triangles and outer vertices when `summary_only`.
ChunkMesh load_chunk_mesh(const ChunkStore& store, ChunkId chunk, bool summary_only);
/// Number of triangles of a stored chunk.
std::uint64_t stored_triangles(const ChunkStore& store, ChunkId chunk);

/// A chunk's points and those of its halo, in canonical order.
ChunkPoints load_chunk_with_halo(const ChunkStore& store, const Partition& partition, ChunkId chunk,
                                 double halo);

/// The stage; chunks that the store holds already under the same radii are not computed again.
void reconstruct_chunks(JobContext& context, const Partition& partition,
                        const std::vector<double>& radii);

}  // namespace orbweave
