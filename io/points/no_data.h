// No-data values: what programs write in place of a coordinate that was not measured.
#pragma once

#include <cmath>

#include "io/vec3.h"

namespace orbweave {

/// The largest float or its negative, as programs write it with six digits and more.
inline bool is_no_data_value(double coordinate) {
  const double size = std::abs(coordinate);
  return size > 3.402e38 && size < 3.403e38;
}

/// A point that holds a no-data value is no place. No motion of a scan and no other coordinates
/// apply to such a point, which stays what it was read as: a turn would make its coordinates
/// look like measured ones.
inline bool holds_no_data_value(Vec3 p) {
  return is_no_data_value(p.x) || is_no_data_value(p.y) || is_no_data_value(p.z);
}

}  // namespace orbweave
