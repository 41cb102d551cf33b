// The chunks' parts of the mesh in the chunk store.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stages.h"
#include "engine/stitching/chunk_mesh.h"

namespace orbweave {

/// Arrays of the results: Triangle in the chunk's own numbers (local_numbers.h), in the order of
/// the mesh; the vertices among them that others own.
inline constexpr const char* kStoredTriangles = "triangles";
inline constexpr const char* kStoredOuter = "outer_vertices";
/// One value per own point where the method tells of it, else none.
inline constexpr const char* kStoredUndersampled = "undersampled";

/// What is counted beside a mesh, of a chunk or of the whole, as it is stored behind other counts.
std::array<std::uint64_t, 12> doubt_counts(const VoronoiFacts& voronoi, const SideFacts& sides);
/// `counts`: doubt_counts(); `sides.place` stays.
void take_doubt_counts(std::span<const std::uint64_t> counts, VoronoiFacts& voronoi,
                       SideFacts& sides);

void commit_chunk_mesh(ChunkStore& store, ChunkId chunk, const ChunkMesh& mesh);
/// Everything but triangles, outer vertices and flags of points when `summary_only`.
ChunkMesh load_chunk_mesh(const ChunkStore& store, ChunkId chunk, bool summary_only);
/// Number of triangles of a stored chunk.
std::uint64_t stored_triangles(const ChunkStore& store, ChunkId chunk);

/// Removes the stitched mesh where the mesh of some chunk is about to be made anew. Only the leader
/// calls it.
void drop_stitch_of_unfinished_mesh(ChunkStore& store, const Partition& partition);

}  // namespace orbweave
