// Whether the columns of a cloud that a program filled in belong together.
#pragma once

#include <cstddef>

#include "io/point_cloud.h"

namespace orbweave {

/// Throws Error (usage) where there are normals, but not as many as positions.
void check_normal_count(std::size_t normals, std::size_t positions);

/// Holds a cloud to the invariant of PointCloud. Throws Error (usage).
void check_columns(const PointCloud& cloud);

}  // namespace orbweave
