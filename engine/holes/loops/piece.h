// A connected piece of the mesh, as the choice of holes knows it.
#pragma once

#include <cstdint>

#include "io/box.h"

namespace orbweave {

struct Piece {
  std::uint64_t triangles = 0;
  Box box;
};

}  // namespace orbweave
