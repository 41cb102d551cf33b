// A power of two that brings coordinates of any magnitude into the range of floats.
#pragma once

#include <cmath>

namespace orbweave {

/// The power of two that takes a length to between 1 and 2, without rounding; 1 for 0 and for what
/// is not finite.
inline double unit_scale(double length) {
  return length > 0.0 && std::isfinite(length) ? std::ldexp(1.0, -std::ilogb(length)) : 1.0;
}

}  // namespace orbweave
