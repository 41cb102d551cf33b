#include "engine/holes/patch/patch_intersections.h"

#include <span>
#include <vector>

#include "engine/geometry/triangle_intersection.h"
#include "engine/holes/patch/box_tree.h"

namespace orbweave {

std::vector<Contact> find_contacts(const HoleProblem& problem, const HolePatch& patch,
                                   std::uint64_t limit) {
  std::vector<Vec3> positions = problem.positions;
  positions.insert(positions.end(), patch.positions.begin(), patch.positions.end());
  return find_contacts(positions, patch.triangles, problem.sheet, limit);
}

std::vector<Contact> find_contacts(std::span<const Vec3> positions, std::span<const Triangle> own,
                                   std::span<const Triangle> sheet, std::uint64_t limit) {
  std::vector<Contact> contacts;
  if (own.empty() || limit == 0) return contacts;
  const BoxTree tree(positions, own);
  const auto test = [&](std::uint32_t a, std::uint32_t number, const Triangle& other) {
    if (triangles_intersect(positions, own[a], other)) contacts.push_back({a, number});
    return contacts.size() < limit;
  };
  for (std::uint32_t i = 0; i < own.size(); ++i) {
    const bool more = tree.for_each(box_of(positions, own[i]),
                                    [&](std::uint32_t k) { return k <= i || test(k, i, own[i]); });
    if (!more) return contacts;
  }
  auto number = static_cast<std::uint32_t>(own.size());
  for (const Triangle& t : sheet) {
    const Box box = box_of(positions, t);
    const bool more = !box.intersects(tree.box()) ||
                      tree.for_each(box, [&](std::uint32_t k) { return test(k, number, t); });
    if (!more) return contacts;
    ++number;
  }
  return contacts;
}

std::uint64_t count_intersections(const HoleProblem& problem, const HolePatch& patch,
                                  std::uint64_t limit) {
  return find_contacts(problem, patch, limit).size();
}

}  // namespace orbweave
