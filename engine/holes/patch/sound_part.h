// The part of a patch that crosses nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// The patch without triangles that cross others, and without triangles that would hang on by a
/// vertex alone then. Every vertex of the loop keeps one gap per corner of the loop, every new
/// vertex has one fan, and every piece has an edge of the loop. open_edges counts the edges that
/// are open. `contacts`: all of the patch. FillMethod::kNone where less than half of the triangles
/// are left, because so small a part says nothing about the surface, and where the loop runs along
/// an edge in both directions.
HolePatch sound_part(const HoleProblem& problem, HolePatch patch,
                     const std::vector<Contact>& contacts);

}  // namespace orbweave
