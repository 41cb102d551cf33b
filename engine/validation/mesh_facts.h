// What a mesh is like, and whether it keeps the promises that every stage makes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/mesh_facts.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Counts the facts of a mesh in core. O(n) time for bounded vertex degrees, about 60 bytes per
/// triangle, on the calling TBB arena. How the counts are meant, beyond io/mesh_facts.h:
/// - Degenerate triangles (two equal indices) are counted and otherwise ignored, except by area
///   and checksum.
/// - Triangles with a vertex that is not finite have no area, and no mesh with one is watertight.
/// - A fan is a maximal set of triangles at a vertex, linked over edges of exactly two triangles.
///   A vertex with more than one is non-manifold; ends of an edge of three triangles hence are.
/// - Boundary loops are simple: holes that touch in a vertex are separate loops
///   (engine/validation/boundary_loops.h).
/// - A duplicate has the same three vertices as an earlier triangle, however oriented.
/// - The bounds are those of all vertices; the checksum is MeshChecksum over those that
///   triangles use.
/// Throws Error: bad input for an index outside the vertices, resource for a mesh that is too large
/// (io/mesh_size.h), interrupted.
MeshFacts mesh_facts(const TriangleMesh& mesh, const StopToken* stop = nullptr);

/// Per vertex, whether a triangle has it. Indices in range.
std::vector<std::uint8_t> used_vertices(std::size_t vertices, std::span<const Triangle> triangles);

/// How far vertices lie from their neighbours, about: the side of a square of the surface that each
/// of them has. 0: there is no surface. Indices in range.
double vertex_spacing(const TriangleMesh& mesh);

/// MeshChecksum over the vertices that triangles use, in file order. Indices in range.
std::string mesh_checksum(std::span<const Vec3> positions, std::span<const Triangle> triangles,
                          const StopToken* stop = nullptr);

/// The guarantees of every stage that a mesh violates, one line each with an example: finite
/// vertices, arrays of matching length, indices in range, no degenerate triangle, no triangle
/// twice, no directed edge twice, no edge of more than two triangles. Empty: valid.
std::vector<std::string> validate_mesh(const TriangleMesh& mesh);

}  // namespace orbweave
