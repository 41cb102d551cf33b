// Bridges: edges that a hole's loop runs along both ways, to an island and back
// (engine/holes/loops/islands.h).
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// A problem whose bridges are cut into edges of about `spacing`: the points between are further
/// vertices at its end, which the loop visits on both ways. `place(a, b, t)`: where the point at
/// the share t of the way from vertex a to b lies.
struct BridgedProblem {
  HoleProblem problem;
  std::uint32_t points = 0;  ///< further vertices
};
BridgedProblem cut_bridges(const HoleProblem& problem, double spacing,
                           const std::function<Vec3(std::uint32_t, std::uint32_t, double)>& place);

/// Whether the loop has a bridge.
bool has_bridges(const HoleProblem& problem);

/// The patch of a problem with cut bridges as one of the problem itself: the points on bridges are
/// its first new vertices. Its normals and values there are left to the caller.
void give_bridge_points(const BridgedProblem& bridged, HolePatch& patch);

}  // namespace orbweave
