#include "engine/holes/patch/rim_piercings.h"

#include <algorithm>

#include "engine/geometry/triangle_intersection.h"
#include "engine/holes/patch/box_tree.h"

namespace orbweave {

RimPiercings::RimPiercings(const HoleProblem& problem)
    : RimPiercings(problem, BoxTree::of_sheet(problem.positions, problem.sheet)) {}

RimPiercings::RimPiercings(const HoleProblem& problem, const BoxTree& sheet) {
  const std::vector<std::uint32_t>& loop = problem.loop;
  const std::vector<Vec3>& at = problem.positions;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const std::uint32_t a = loop[k], b = loop[(k + 1) % loop.size()];
    sheet.for_each(box_of(at, {a, b, b}), [&](std::uint32_t i) {
      const Triangle& t = problem.sheet[i];
      const bool is_apart =
          std::none_of(t.begin(), t.end(), [&](std::uint32_t v) { return v == a || v == b; });
      if (is_apart && segment_meets_triangle(at[a], at[b], at[t[0]], at[t[1]], at[t[2]]))
        found_.push_back({{a, b}, i});
      return true;
    });
  }
  std::sort(found_.begin(), found_.end());
}

bool RimPiercings::has(const Triangle& of_patch, std::uint32_t in_sheet) const {
  if (found_.empty()) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Piercing wanted{{of_patch[k], of_patch[(k + 1) % 3]}, in_sheet};
    if (std::binary_search(found_.begin(), found_.end(), wanted)) return true;
  }
  return false;
}

std::uint64_t RimPiercings::count_avoidable(const HolePatch& patch,
                                            const std::vector<Contact>& contacts) const {
  const std::size_t own = patch.triangles.size();
  return static_cast<std::uint64_t>(
      std::count_if(contacts.begin(), contacts.end(), [&](const Contact& contact) {
        return contact[1] < own ||
               !has(patch.triangles[contact[0]], static_cast<std::uint32_t>(contact[1] - own));
      }));
}

}  // namespace orbweave
