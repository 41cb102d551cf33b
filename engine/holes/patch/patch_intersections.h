// Where a patch crosses itself or the sheet that it closes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/patch/box_tree.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// Two triangles that intersect (engine/geometry/triangle_intersection.h): one of the patch by its
/// number there, and another of the patch or, from patch.triangles.size() on, of the sheet.
using Contact = std::array<std::uint32_t, 2>;

/// At most `limit` contacts of a patch with itself and with the gathered sheet. O(n log n) where
/// few boxes overlap.
std::vector<Contact> find_contacts(const HoleProblem& problem, const HolePatch& patch,
                                   std::uint64_t limit = UINT64_MAX);

/// The same with a tree over the problem's sheet: only what is near the patch is looked at.
std::vector<Contact> find_contacts(const HoleProblem& problem, const BoxTree& sheet,
                                   const HolePatch& patch, std::uint64_t limit = UINT64_MAX);

/// The same for patch triangles among these positions; sheet triangles are numbered from
/// patch.size() on.
std::vector<Contact> find_contacts(std::span<const Vec3> positions, std::span<const Triangle> patch,
                                   std::span<const Triangle> sheet,
                                   std::uint64_t limit = UINT64_MAX);

/// Their number.
std::uint64_t count_intersections(const HoleProblem& problem, const HolePatch& patch,
                                  std::uint64_t limit = UINT64_MAX);
std::uint64_t count_intersections(const HoleProblem& problem, const BoxTree& sheet,
                                  const HolePatch& patch, std::uint64_t limit = UINT64_MAX);

}  // namespace orbweave
