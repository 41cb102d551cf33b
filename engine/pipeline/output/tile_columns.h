// The columns of a tile's vertices: those of the one mesh, and the vertices' numbers in it.
#pragma once

#include <cstdint>
#include <span>

#include "io/meshes/mesh_writer.h"

namespace orbweave {

/// Vertices' numbers in the one mesh.
inline constexpr const char* kVertexId = "vertex_id";

/// The mesh's columns and the numbers. A scan's own column of that name gets another one.
PointSchema tile_schema(const MeshHeader& mesh);

/// Adds the numbers to vertices that have the mesh's columns.
void add_vertex_ids(const MeshHeader& mesh, std::span<const std::uint64_t> ids, PointCloud& cloud);

}  // namespace orbweave
