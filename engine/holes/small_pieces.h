// Separate pieces of a mesh in core that are too small to stay, and what is left without them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/loops/mesh_surface.h"
#include "io/stop_token.h"
#include "io/surface_options.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// A mesh in core, looked at once. The mesh has to outlive it.
struct MeshSurvey {
  explicit MeshSurvey(const TriangleMesh& mesh);

  MeshSurface surface;
  std::vector<std::uint32_t> unusual;  ///< unusual_vertices() of it
  MeshComponents components;
};

/// Per piece: 1 where it is smaller than fill.min_triangles or, where that is left open, a crumb of
/// a closed object. Crumbs are told by the vertices' normals, which point outside. `stop` may be
/// null.
std::vector<std::uint8_t> small_pieces(const TriangleMesh& mesh, const MeshSurvey& survey,
                                       const FillOptions& options, const StopToken* stop = nullptr);

/// The mesh without the pieces that are flagged, and without the vertices that no triangle uses.
TriangleMesh without_pieces(TriangleMesh mesh, const MeshComponents& components,
                            std::span<const std::uint8_t> is_removed);

/// The points that triangles use, and these triangles in their numbers.
TriangleMesh used_part(PointCloud points, std::vector<Triangle> triangles);

}  // namespace orbweave
