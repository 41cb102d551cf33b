// Pictures of meshes in core.
#pragma once

#include <string>

#include "io/box.h"
#include "io/report/picture.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Draws the mesh, filled holes tinted, to a PNG. Throws Error (resource).
void draw_mesh(const TriangleMesh& mesh, const Box& bounds, const std::string& path,
               const PictureOptions& options = {});

}  // namespace orbweave
