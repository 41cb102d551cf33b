// Where a loop's own edges run into the sheet: what no patch can help.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// Triangles of the sheet that an edge of the loop meets. Whatever patch closes the loop, its
/// triangle at that edge meets them, too: no patch is clear, and no move of a vertex helps.
class RimPiercings {
 public:
  explicit RimPiercings(const HoleProblem& problem);
  /// `sheet`: of the problem's sheet.
  RimPiercings(const HoleProblem& problem, const BoxTree& sheet);

  bool any() const { return !found_.empty(); }
  /// Whether a triangle of a patch has an edge of the loop that meets the sheet's triangle.
  bool has(const Triangle& of_patch, std::uint32_t in_sheet) const;
  /// How many of the patch's contacts another patch could do without.
  std::uint64_t count_avoidable(const HolePatch& patch, const std::vector<Contact>& contacts) const;

 private:
  struct Piercing {
    std::array<std::uint32_t, 2> edge{};
    std::uint32_t in_sheet = 0;
    friend auto operator<=>(const Piercing&, const Piercing&) = default;
  };
  std::vector<Piercing> found_;  // sorted
};

}  // namespace orbweave
