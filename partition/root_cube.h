// The cube that every octree node and every Morton code refers to.
#pragma once

#include <cstdint>

#include "io/box.h"

namespace orbweave {

/// Levels of the fine Morton code: 21 bits per axis, 63 in all.
inline constexpr int kMortonDepth = 21;

/// A cube whose side is a power of two and whose origin is a multiple of side / 256, so that
/// every power-of-two lattice of cells up to that size, anchored at zero, nests in it.
struct RootCube {
  Vec3 origin;
  double side = 1.0;
  double cell(int depth) const;  ///< side of an octree node at that depth
  friend bool operator==(const RootCube&, const RootCube&) = default;
};

/// The cube around a cloud. Depends on the bounds alone, hence not on the order of points nor
/// on the partition. A cloud without extent gets a cube of a size that its coordinates resolve.
/// Precondition: finite, non-empty bounds. Throws Error (bad input) beyond an extent of 1e301.
RootCube root_cube(const Box& bounds);

}  // namespace orbweave
