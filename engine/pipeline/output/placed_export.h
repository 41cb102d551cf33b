// The mesh file of a format whose rows have a fixed width, written by all threads and by all
// processes of a team at once: every piece goes to its place in one file.
#pragma once

#include "engine/pipeline/output/mesh_pieces.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "io/meshes/mesh_writer.h"

namespace orbweave {

/// Writes job.output.mesh; it appears whole or not at all. Every member of the team calls it.
/// The leader's `digest` is that of the mesh, the others' of what they wrote. Returns false, with
/// nothing written, where the target is no regular file. `bytes_written` gets the size of the file.
bool export_placed(StageRunner& runner, const MeshPieces& pieces, const VertexColumns& columns,
                   const MeshHeader& header, const MeshRows& rows, SurfaceDigest& digest,
                   std::uint64_t& bytes_written);

}  // namespace orbweave
