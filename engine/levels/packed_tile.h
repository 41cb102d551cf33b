// Tiles whose rows are compressed without loss, by meshoptimizer.
#pragma once

#include <filesystem>

#include "io/meshes/mesh_writer.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Writes a GLB file with the extension EXT_meshopt_compression. What it holds is what write_mesh()
/// writes, bit by bit, in another order: triangles follow each other along the surface, each begins
/// at any of its corners, and vertices come as triangles need them. The bytes depend on the mesh
/// and the options alone. O(vertices + triangles). Precondition: every vertex has a triangle.
void write_packed_tile(const std::filesystem::path& file, const TriangleMesh& mesh,
                       const MeshWriterOptions& options);

}  // namespace orbweave
