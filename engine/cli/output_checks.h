// What a command finds out about its outputs before it works rather than after.
#pragma once

#include "io/job/job.h"

namespace orbweave {

/// Throws Error (usage) where no mesh can be written under this name.
void check_mesh_name(const OutputOptions& output);

}  // namespace orbweave
