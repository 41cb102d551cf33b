// The names that attributes have in a file.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/point_cloud.h"
#include "io/text/distinct_names.h"

namespace orbweave {

/// Names of the attributes beside columns x, y, z and, where there are normals, nx, ny, nz: no two
/// alike. `plain`: a name as the format can have it. A name that stays as it is goes before one
/// that becomes the same.
std::vector<std::string> attribute_names(const PointSchema& schema,
                                         const std::function<std::string(std::string)>& plain,
                                         DistinctNames::Meaning meaning = {});

}  // namespace orbweave
