// The ground of a scene, among the patches of its points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/normals/orientation_graph.h"
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

/// Takes the undersides of objects out of the ground: a ball that stands on a floor hides the floor
/// below itself from scanners, and nothing lies below its lowest patches then. Of a surface that
/// encloses a volume, the floor of a room is as large as the ceiling is, as seen from above; where
/// the ground is a much smaller share of what faces up or down, it is none. `edges`: the votes
/// between patches, by their rows. `is_ground`: as find_ground has it. O(n log n), of the patches
/// that are connected with little ground; O(n) of the others.
void leave_out_undersides(std::span<const PatchSum> sums, std::span<const SignedEdge> edges,
                          Vec3 up, std::span<std::uint8_t> is_ground,
                          const StopToken* stop = nullptr);

}  // namespace orbweave
