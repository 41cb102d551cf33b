// The mesh of one node of the octree of levels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/levels/sorted_triangles.h"
#include "engine/levels/vertex_table.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Vertices are those of the whole mesh, with their rows of the vertex table.
struct NodeMesh {
  std::vector<std::uint64_t> vertices;  ///< numbers in the whole mesh, ascending
  std::vector<std::byte> rows;          ///< one of each vertex
  std::vector<Triangle> triangles;      ///< of places in `vertices`
};

/// The mesh of a leaf: all triangles of its cell. Throws Error (bad input) where a corner is not
/// finite.
NodeMesh leaf_mesh(const VertexTable& table, std::span<const CodedTriangle> triangles);

/// Meshes of children put together over the vertices that they share, one after another.
NodeMesh merged_mesh(std::span<const NodeMesh> parts, std::size_t row_bytes);

/// The vertices that triangles use, and the triangles over these.
NodeMesh used_part(const NodeMesh& mesh, std::vector<Triangle> triangles, std::size_t row_bytes);

/// Positions of all vertices.
std::vector<Vec3> positions_of(const NodeMesh& mesh, std::size_t row_bytes);

/// As bytes and back.
std::vector<std::byte> packed(const NodeMesh& mesh);
NodeMesh unpacked(std::span<const std::byte> bytes, std::size_t row_bytes);

/// Triangles with an edge that no other triangle of the mesh has.
std::uint64_t border_triangles(const NodeMesh& mesh);

}  // namespace orbweave
