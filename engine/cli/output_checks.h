// What a command finds out about its outputs before it works rather than after.
#pragma once

#include <string>
#include <vector>

#include "io/job/job.h"
#include "io/system/path_roles.h"

namespace orbweave {

/// Throws Error (usage) where no mesh can be written under this name.
void check_mesh_name(const OutputOptions& output);

/// The files that a mesh of this name is written to: the mesh, its numbers where the format keeps
/// them apart, its coordinate system, its shift of coordinates.
std::vector<PathRole> files_of_mesh(const std::string& mesh);

}  // namespace orbweave
