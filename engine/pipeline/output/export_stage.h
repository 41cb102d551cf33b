// From the chunk store to the mesh file: vertices in canonical order, then triangles sorted by
// their vertices, then the patches of holes in their order, all streamed; and the picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/pipeline/surface/filled_holes.h"
#include "engine/pipeline/surface/used_vertices.h"
#include "io/job/output_origin.h"

namespace orbweave {

/// Throws Error (usage) where the mesh of so many points is bound to be too large for its format; a
/// closed surface has twice as many triangles as vertices.
void check_format_holds(const OutputOptions& output, std::uint64_t points,
                        const PointSchema& vertices = {});

/// What the vertices of the mesh file carry, as far as its format has a place for it.
PointSchema vertex_schema(const OutputOptions& output, const Partition& partition);

/// Where the coordinates of the mesh file are counted from.
OutputOrigin mesh_origin(const OutputOptions& output, const Partition& partition);

struct ExportInputs {
  const Partition& partition;
  const std::vector<std::uint64_t>& triangles;  ///< stored ones, per chunk
  const UsedVertices& used;
  const FilledHoles& holes;
  const MeshFacts& facts;  ///< counts of the mesh
};

struct ExportResult {
  std::string checksum;
  Box bounds;
  std::uint64_t bytes_written = 0;  ///< of the mesh
};

/// Export stage: writes the mesh. Checksum and bounds are the leader's alone.
ExportResult export_mesh(const ExportInputs& inputs, StageRunner& runner);

}  // namespace orbweave
