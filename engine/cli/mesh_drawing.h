// Pictures of meshes in core.
#pragma once

#include <span>
#include <string>

#include "io/report/picture.h"
#include "io/triangle_mesh.h"

namespace orbweave {

struct MeshDrawing {
  PictureOptions picture;
  PictureColors colors = PictureColors::kPatches;
  PictureBacks backs = PictureBacks::kAuto;
};

/// Draws the mesh, with a legend, to a PNG; fitted to the vertices that triangles use. Throws Error
/// (resource).
void draw_mesh(const TriangleMesh& mesh, const std::string& path, const MeshDrawing& drawing = {});

/// Draws the mesh, from the side that shows fronts, in colours that tell a number per triangle,
/// from 0 to 1; `large`: in words, what 1 stands for.
void draw_mesh_by_shares(const TriangleMesh& mesh, std::span<const float> shares,
                         const std::string& large, const std::string& path,
                         const PictureOptions& options = {});

}  // namespace orbweave
