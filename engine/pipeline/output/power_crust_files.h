// Files of a Power Crust beside its mesh: the polygons and the medial axis.
#pragma once

#include <cstdint>

#include "engine/pipeline/output/mesh_pieces.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "io/meshes/mesh_writer.h"

namespace orbweave {

/// Throws Error (usage) where the job asks for them and makes no Power Crust, or for a format that
/// cannot hold them.
void check_power_crust_files(const Job& job);

/// Writes those that the job asks for, with the vertices and coordinates of the mesh file, and says
/// how much is in them. Small pieces that the mesh lost are still there. Returns their bytes.
/// `vertices`: the partition of the surface's vertices.
std::uint64_t write_power_crust_files(const Partition& vertices, const VertexColumns& columns,
                                      const MeshWriterOptions& options, StageRunner& runner);

}  // namespace orbweave
