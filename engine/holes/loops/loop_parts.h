// Loops that touch themselves, taken apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "engine/holes/patch/box_tree.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// The loop cut at vertices that it visits several times into loops that visit each of theirs
/// once, innermost first. Empty where it is such a loop already, or where a part would have fewer
/// than three edges (a bridge, which the loop runs along both ways).
std::vector<std::vector<std::uint32_t>> simple_parts(const std::vector<std::uint32_t>& loop);

/// One patch from those that `fill` makes for the parts, which it gets with their numbers in the
/// order of simple_parts. No part uses an edge that another one might. Flat where most of its area
/// is; its confidence is the mean of theirs by area. FillMethod::kNone where a part stays open or
/// there is no cut. The vertices at which the loop is cut keep several fans.
/// `sheet`: of the problem's sheet.
HolePatch fill_by_parts(const HoleProblem& problem, const BoxTree& sheet,
                        const std::function<HolePatch(const HoleProblem&, std::size_t)>& fill);

}  // namespace orbweave
