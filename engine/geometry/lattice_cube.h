// The cube of a lattice, anchored at the world's zero, that a point lies in.
#pragma once

#include <cstdint>

#include "engine/geometry/lattice_box.h"
#include "io/vec3.h"

namespace orbweave {

/// The largest whole number that is no larger; without a call of the C library.
inline std::int64_t whole_below(double x) {
  const auto whole = static_cast<std::int64_t>(x);
  return static_cast<double>(whole) > x ? whole - 1 : whole;
}

inline LatticeCell cube_of(Vec3 p, double side) {
  return {whole_below(p.z / side), whole_below(p.y / side), whole_below(p.x / side)};
}

}  // namespace orbweave
