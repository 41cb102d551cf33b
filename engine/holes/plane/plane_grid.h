// New points over a hole's plane.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/holes/patch/rim.h"
#include "engine/holes/plane/plane_heights.h"
#include "engine/holes/plane/plane_outline.h"

namespace orbweave {

/// A place over the plane, with the interpolant's height, and how steep it is there.
struct GridPoint {
  Vec3 place;
  Vec3 slope;  ///< gradient of the height; z is 0
};

/// Points of a hexagonal lattice inside the loop, clear of its edges, in plane coordinates and
/// with the interpolant's height: at the spacing of the rim's edges nearby, denser where the patch
/// is steep, and where `graded` coarser far from the rim (nested lattices, each of half the spacing
/// of the one before). The lattice lies at the frame's origin. Empty where there would be more than
/// `most`. A large hole's are found by all threads.
std::optional<std::vector<GridPoint>> plane_grid(const Rim& rim, const PlaneOutline& outline,
                                                 const HoleHeights& heights, bool graded,
                                                 std::uint32_t most, const StopToken* stop);

/// About how many points plane_grid() gives at most, inside a rim of so many edges.
double expected_grid_points(std::uint64_t edges, bool graded);

/// The largest distance from the outline that plane_grid asks for.
double grid_clearance(const Rim& rim);

}  // namespace orbweave
