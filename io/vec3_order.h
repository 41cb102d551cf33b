// An order of places, the same on every machine.
#pragma once

#include <tuple>

#include "io/vec3.h"

namespace orbweave {

/// By x, then by y, then by z. An object, not a function, so that sorting compares without a call.
inline constexpr auto comes_before = [](const Vec3& a, const Vec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
};

}  // namespace orbweave
