// Whether a mesh can be written under a name, known before the work.
#pragma once

#include "io/job/job.h"

namespace orbweave {

/// Throws Error (usage) where no mesh can be written under this name.
void check_mesh_name(const OutputOptions& output);

}  // namespace orbweave
