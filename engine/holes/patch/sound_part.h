// The part of a patch that meets nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// The patch without triangles that meet others, and without what would hang on by a vertex alone
/// then: every vertex keeps one gap per corner of the loop, every new one has one fan, and every
/// piece has an edge of the loop. Its open edges are counted in open_edges. `contacts`: all of the
/// patch. FillMethod::kNone where less than half of the triangles are left: what remains of such a
/// patch says nothing about the surface; and where the loop runs along an edge both ways.
HolePatch sound_part(const HoleProblem& problem, HolePatch patch,
                     const std::vector<Contact>& contacts);

}  // namespace orbweave
