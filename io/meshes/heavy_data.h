// The file beside an XDMF document that has its numbers.
#pragma once

#include <filesystem>

#include "io/text/file_format.h"

namespace orbweave {

/// "mesh.h5" of "mesh.xdmf"; empty for every other format.
inline std::filesystem::path heavy_data_file(const std::filesystem::path& mesh) {
  const auto named = format_of_name(mesh);
  if (!named || named->facts.format != FileFormat::kXdmf) return {};
  return std::filesystem::path(mesh).replace_extension(".h5");
}

/// A job does not name that file: it is written only where there is none, or one with the arrays of
/// a mesh. Throws Error (usage) otherwise, and where an XML document cannot hold its name.
void check_heavy_data(const std::filesystem::path& mesh);

}  // namespace orbweave
