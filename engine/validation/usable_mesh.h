// Meshes from files that are to be computed with.
#pragma once

#include <string>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// Reads a mesh, as read_mesh() does. Throws Error (resource) for one that is too large
/// (io/mesh_size.h), and (bad input) for coordinates that cannot be computed with
/// (engine/validation/usable_scale.h). `left_out`: as of read_mesh().
TriangleMesh read_usable_mesh(const std::string& file,
                              std::vector<std::string>* left_out = nullptr);

}  // namespace orbweave
