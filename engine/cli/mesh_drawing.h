// Pictures of meshes in core.
#pragma once

#include <span>
#include <string>

#include "io/box.h"
#include "io/report/picture.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Draws the mesh, filled holes tinted, to a PNG; without back faces on request. Throws Error
/// (resource).
void draw_mesh(const TriangleMesh& mesh, const Box& bounds, const std::string& path,
               const PictureOptions& options = {}, bool culls_backs = false);

/// Draws the mesh in colours that tell a number per triangle, from 0 to 1.
void draw_mesh_by_shares(const TriangleMesh& mesh, std::span<const float> shares,
                         const std::string& path, const PictureOptions& options = {});

}  // namespace orbweave
