// The mesh of one node of the octree of levels.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/levels/face_tags.h"
#include "engine/levels/sorted_triangles.h"
#include "engine/levels/vertex_table.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Vertices are those of the whole mesh, with their rows of the vertex table.
struct NodeMesh {
  std::vector<std::uint64_t> vertices;  ///< numbers in the whole mesh, ascending
  std::vector<std::byte> rows;          ///< one of each vertex
  std::vector<Triangle> triangles;      ///< of places in `vertices`
  std::vector<FaceTag> tags;            ///< of each triangle; empty: none is kept
};

/// The mesh of a leaf without rows of vertices: all triangles of its cell. Tags have no component.
NodeMesh bare_leaf(std::span<const CodedTriangle> triangles);

/// The mesh of a leaf. Throws Error (bad input) where a corner is not finite.
NodeMesh leaf_mesh(const VertexTable& table, std::span<const CodedTriangle> triangles);

/// Meshes of children put together over the vertices that they share, one after another.
NodeMesh merged_mesh(std::span<const NodeMesh> parts, std::size_t row_bytes);

/// The vertices that triangles use, and the triangles over these, without tags.
NodeMesh used_part(const NodeMesh& mesh, std::vector<Triangle> triangles, std::size_t row_bytes);

/// Positions of all vertices.
std::vector<Vec3> positions_of(const NodeMesh& mesh, std::size_t row_bytes);

/// As bytes and back.
std::vector<std::byte> packed(const NodeMesh& mesh);
NodeMesh unpacked(std::span<const std::byte> bytes, std::size_t row_bytes);

/// An edge that one triangle of a node has, by places of vertices in the node.
struct OpenEdge {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t triangle = 0;
  friend auto operator<=>(const OpenEdge&, const OpenEdge&) = default;
};

/// All of a node: at its border, and at rims of the mesh. Ascending.
std::vector<OpenEdge> open_edges(const NodeMesh& mesh);
/// How many triangles have one of these edges.
std::uint64_t triangles_at(std::span<const OpenEdge> edges);

/// An edge by the numbers of its vertices in the whole mesh, the lower one first.
using MeshEdge = std::array<std::uint64_t, 2>;
MeshEdge mesh_edge(const NodeMesh& mesh, const OpenEdge& edge);

}  // namespace orbweave
