// What the tiles of a mesh are made from.
#pragma once

#include "engine/pipeline/output/mesh_pieces.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/surface/filled_holes.h"
#include "engine/pipeline/surface/used_vertices.h"
#include "io/meshes/mesh_writer.h"
#include "io/stop_token.h"

namespace orbweave {

/// Everything must outlive the export.
struct TileInput {
  const Partition& partition;
  const UsedVertices& used;
  const FilledHoles& holes;
  const MeshPieces& pieces;
  const VertexColumns& columns;
  const MeshHeader& header;  ///< of the one mesh
  const MeshWriterOptions& options;
  const StopToken& stop;
};

}  // namespace orbweave
