// The cube of a lattice, anchored at the world's zero, that a point lies in.
#pragma once

#include <cmath>

#include "engine/geometry/neighbor_grid.h"
#include "io/vec3.h"

namespace orbweave {

inline LatticeCell cube_of(Vec3 p, double side) {
  return {static_cast<std::int64_t>(std::floor(p.z / side)),
          static_cast<std::int64_t>(std::floor(p.y / side)),
          static_cast<std::int64_t>(std::floor(p.x / side))};
}

}  // namespace orbweave
