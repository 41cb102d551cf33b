// Patches that meet the surface in a few places, moved out of its way.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/holes/patch/box_tree.h"
#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/patch/rim_piercings.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// Moves new vertices of triangles that intersect others, by little more than a rim spacing, to
/// where fewer of theirs do; triangles between corners of the loop alone get a new vertex first.
/// The surface of a scan often sticks out beside a hole's rim, and a patch that starts along it
/// runs into that. Returns the contacts that are left; a patch of more than 1,000 is left as
/// it is, and so is one whose contacts are all those of the loop's own edges.
/// `sheet`: of the problem's sheet. `contacts`: those of the patch.
std::vector<Contact> untangle(const HoleProblem& problem, const RimPiercings& piercings,
                              const BoxTree& sheet, std::vector<Contact> contacts,
                              HolePatch& patch);

/// The same from the problem alone; returns how many are left.
std::uint64_t untangle(const HoleProblem& problem, HolePatch& patch);

}  // namespace orbweave
