// What an E57 file holds and no point has.
#pragma once

#include <string>
#include <vector>

#include "io/clouds/e57/e57_document.h"
#include "io/clouds/e57/e57_layout.h"

namespace orbweave {

/// Of the points of all scans, in words: fields of extensions, normals where a scan has none, and
/// attributes that some scans lack.
std::vector<std::string> lost_values_of_e57(const std::vector<E57Scan>& scans,
                                            const E57Layout& layout);

}  // namespace orbweave
