// Which patches stay where patches cross.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "engine/geometry/crossing_pairs.h"

namespace orbweave {

/// Two holes whose patches cross, by their ids, the smaller first; 0: the surface.
using HolePair = std::array<std::int32_t, 2>;

/// The holes of crossing triangles, sorted. `hole`: per triangle; 0: the surface.
std::vector<HolePair> holes_of_pairs(std::span<const TrianglePair> pairs,
                                     std::span<const std::int32_t> hole);

/// Holes that stay open because their patches would cross something, and what.
using DroppedHoles = std::map<std::int32_t, std::string>;

/// Patches that cross the surface or themselves go; then, of two that cross each other, the one
/// with the larger id. `pairs` sorted.
DroppedHoles patches_to_drop(std::span<const HolePair> pairs);

}  // namespace orbweave
