// The ground of a scene, among the patches of its points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/normals/patch_sums.h"
#include "io/stop_token.h"

namespace orbweave {

/// 1 for patches that belong to the ground: no patch nearby lies further below one than a slope of
/// one in two explains, and its plane is nearer to the horizontal than to the vertical. The slope
/// is the filter of Vosselman: Slope based filtering of laser altimetry data, 2000, for patches
/// instead of points. `cell`: side of the patches' lattice, world units. `up`: a unit vector.
/// O(n log n).
std::vector<std::uint8_t> find_ground(std::span<const PatchSum> sums, double cell, Vec3 up,
                                      const StopToken* stop = nullptr);

}  // namespace orbweave
