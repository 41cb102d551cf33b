// The mesh as tiles: a file per chunk with the chunk's triangles and all vertices that they use.
// Every vertex has the number that it has in the one mesh, so tiles can be joined exactly.
// docs/output.md has the files.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/pipeline/job_context.h"
#include "engine/pipeline/mesh_pieces.h"
#include "engine/pipeline/partition_stage.h"
#include "io/mesh_writer.h"

namespace orbweave {

/// Vertices' numbers in the one mesh.
inline constexpr const char* kVertexId = "vertex_id";

/// Throws Error (usage) where the job's mesh cannot be written as tiles.
void check_tiles(const OutputOptions& output);

/// What tiles are made from. Everything must outlive the export.
struct TileInput {
  const Partition& partition;
  const UsedVertices& used;
  const FilledHoles& holes;
  const MeshPieces& pieces;
  const MeshHeader& header;  ///< of the one mesh
};

/// Writes the directory of tiles; every member of the team calls it. `digest` is the leader's.
/// Returns the bytes of the files.
std::uint64_t export_tiles(JobContext& context, StageClock& clock, const TileInput& input,
                           SurfaceDigest& digest);

}  // namespace orbweave
