// The files that a command writes for a mesh.
#pragma once

#include <string>
#include <vector>

#include "io/system/path_roles.h"

namespace orbweave {

/// The files that a mesh of this name is written to: the mesh, its numbers where the format keeps
/// them apart, its coordinate system, its shift of coordinates.
std::vector<PathRole> files_of_mesh(const std::string& mesh);

}  // namespace orbweave
