// Patches that meet the surface in a few places, moved out of its way.
#pragma once

#include <cstdint>

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// Moves new vertices of triangles that intersect others, by little more than a rim spacing, to
/// where fewer of theirs do; triangles between corners of the loop alone get a new vertex first.
/// The surface of a scan often sticks out beside a hole's rim, and a patch that starts along it
/// runs into that. Returns how many contacts are left; a patch of more than 1,000 is left as
/// it is.
std::uint64_t untangle(const HoleProblem& problem, HolePatch& patch);

}  // namespace orbweave
