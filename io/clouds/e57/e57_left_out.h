// What an E57 file holds and no point has.
#pragma once

#include <string>
#include <vector>

#include "io/clouds/e57/e57_document.h"

namespace orbweave {

/// Of the points of all scans, in words: fields of extensions, and normals where a scan has none.
std::vector<std::string> lost_values_of_e57(const std::vector<E57Scan>& scans, bool has_normals);

}  // namespace orbweave
