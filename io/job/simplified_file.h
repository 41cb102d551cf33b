// Where a job's simplified mesh goes.
#pragma once

#include <filesystem>

#include "io/job/job.h"

namespace orbweave {

/// output.simplified, else the mesh's name with ".simplified.ply" for its extension. Empty where
/// the job asks for no simplified mesh.
inline std::filesystem::path simplified_file(const OutputOptions& output) {
  if (!output.simplify) return {};
  if (!output.simplified.empty()) return output.simplified;
  return std::filesystem::path(output.mesh).replace_extension(".simplified.ply");
}

}  // namespace orbweave
