// How large a mesh in core may be.
#pragma once

#include <cstdint>
#include <string>

namespace orbweave {

/// Most vertices of a mesh in core, and the number of triangles from which on a mesh is too large.
/// 32 bits number the vertices, and the three corners of each triangle.
inline constexpr std::uint64_t kMostMeshVertices = UINT32_MAX;
inline constexpr std::uint64_t kTooManyTriangles = UINT32_MAX / 3;

/// Throws Error (resource) for a larger mesh. `file` may be empty.
void require_mesh_in_core(const std::string& file, std::uint64_t vertices, std::uint64_t triangles);

}  // namespace orbweave
