#include "engine/holes/patch/rim_piercings.h"

#include <algorithm>

#include "engine/geometry/triangle_intersection.h"
#include "engine/holes/patch/box_tree.h"

namespace orbweave {

RimPiercings::RimPiercings(const HoleProblem& problem) {
  const std::vector<std::uint32_t>& loop = problem.loop;
  const std::vector<Vec3>& at = problem.positions;
  std::vector<Triangle> edges;  // flat ones
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const std::uint32_t next = loop[(i + 1) % loop.size()];
    edges.push_back({loop[i], next, next});
  }
  const BoxTree tree(at, edges);
  for (std::uint32_t i = 0; i < problem.sheet.size(); ++i) {
    const Triangle& t = problem.sheet[i];
    const Box box = box_of(at, t);
    if (!box.intersects(tree.box())) continue;
    tree.for_each(box, [&](std::uint32_t e) {
      const std::uint32_t a = edges[e][0], b = edges[e][1];
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
