// Points taken out of a cloud in place.
#pragma once

#include <cstdint>
#include <span>

#include "io/point_cloud.h"

namespace orbweave {

/// Keeps the points whose flag is not 0, in their order. There is a flag for every point.
void keep_points(std::span<const std::uint8_t> kept, PointCloud& cloud);

}  // namespace orbweave
