#include "engine/holes/patch/patch_intersections.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <span>
#include <vector>

#include "engine/geometry/triangle_intersection.h"
#include "engine/holes/patch/box_tree.h"

namespace orbweave {
namespace {

class ContactSearch {
 public:
  /// `near`: the sheet's triangles that may meet the patch, ascending.
  ContactSearch(std::span<const Vec3> positions, std::span<const Triangle> own, const BoxTree& tree,
                std::span<const Triangle> sheet, std::span<const std::uint32_t> near)
      : positions_(positions), own_(own), tree_(tree), sheet_(sheet), near_(near) {
    planes_.reserve(own.size());
    for (const Triangle& t : own) planes_.emplace_back(positions, t);
  }

  /// Triangles that others are looked for at: those of the patch, then of the sheet.
  std::size_t size() const { return own_.size() + near_.size(); }

  std::vector<Contact> contacts(std::size_t begin, std::size_t end, std::uint64_t limit) const {
    std::vector<Contact> contacts;
    for (std::size_t i = begin; i < end; ++i) {
      const bool is_own = i < own_.size();
      const std::size_t number = is_own ? i : own_.size() + near_[i - own_.size()];  // in contacts
      const Triangle& t = is_own ? own_[i] : sheet_[number - own_.size()];
      const ApartByPlane plane = is_own ? planes_[i] : ApartByPlane(positions_, t);
      const bool more = tree_.for_each(box_of(positions_, t), [&](std::uint32_t k) {
        if (is_own && k <= i) return true;
        if (plane.has_beside(positions_, own_[k]) || planes_[k].has_beside(positions_, t))
          return true;
        if (triangles_intersect(positions_, own_[k], t))
          contacts.push_back({k, static_cast<std::uint32_t>(number)});
        return contacts.size() < limit;
      });
      if (!more) break;
    }
    return contacts;
  }

  std::vector<Contact> contacts(std::uint64_t limit) const {
    // Where all are wanted of many, by all threads: others wait for so large a hole.
    constexpr std::size_t kMany = 50'000;
    if (limit != UINT64_MAX || size() < kMany) return contacts(0, size(), limit);
    constexpr std::size_t kBlock = 4096;
    std::vector<std::vector<Contact>> blocks((size() + kBlock - 1) / kBlock);
    tbb::this_task_arena::isolate([&] {
      tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
        const std::size_t end = std::min((i + 1) * kBlock, size());
        blocks[i] = contacts(i * kBlock, end, UINT64_MAX);
      });
    });
    std::vector<Contact> all;
    for (const std::vector<Contact>& block : blocks)
      all.insert(all.end(), block.begin(), block.end());
    return all;
  }

 private:
  std::span<const Vec3> positions_;
  std::span<const Triangle> own_;
  const BoxTree& tree_;
  std::span<const Triangle> sheet_;
  std::span<const std::uint32_t> near_;
  std::vector<ApartByPlane> planes_;  // of the patch's triangles
};

std::vector<Vec3> all_positions(const HoleProblem& problem, const HolePatch& patch) {
  std::vector<Vec3> positions;
  positions.reserve(problem.positions.size() + patch.positions.size());
  positions.insert(positions.end(), problem.positions.begin(), problem.positions.end());
  positions.insert(positions.end(), patch.positions.begin(), patch.positions.end());
  return positions;
}

}  // namespace

std::vector<Contact> find_contacts(const HoleProblem& problem, const HolePatch& patch,
                                   std::uint64_t limit) {
  return find_contacts(all_positions(problem, patch), patch.triangles, problem.sheet, limit);
}

std::vector<Contact> find_contacts(const HoleProblem& problem, const BoxTree& sheet,
                                   const HolePatch& patch, std::uint64_t limit) {
  if (patch.triangles.empty() || limit == 0) return {};
  const std::vector<Vec3> positions = all_positions(problem, patch);
  const BoxTree tree(positions, patch.triangles);
  const std::vector<std::uint32_t> near = sheet.near(tree.box());
  return ContactSearch(positions, patch.triangles, tree, problem.sheet, near).contacts(limit);
}

std::vector<Contact> find_contacts(std::span<const Vec3> positions, std::span<const Triangle> own,
                                   std::span<const Triangle> sheet, std::uint64_t limit) {
  if (own.empty() || limit == 0) return {};
  const BoxTree tree(positions, own);
  std::vector<std::uint32_t> near;
  for (std::uint32_t i = 0; i < sheet.size(); ++i)
    if (box_of(positions, sheet[i]).intersects(tree.box())) near.push_back(i);
  return ContactSearch(positions, own, tree, sheet, near).contacts(limit);
}

std::uint64_t count_intersections(const HoleProblem& problem, const HolePatch& patch,
                                  std::uint64_t limit) {
  return find_contacts(problem, patch, limit).size();
}

std::uint64_t count_intersections(const HoleProblem& problem, const BoxTree& sheet,
                                  const HolePatch& patch, std::uint64_t limit) {
  return find_contacts(problem, sheet, patch, limit).size();
}

}  // namespace orbweave
