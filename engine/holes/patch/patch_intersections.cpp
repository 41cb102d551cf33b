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
  ContactSearch(std::span<const Vec3> positions, std::span<const Triangle> own,
                std::span<const Triangle> sheet)
      : positions_(positions), own_(own), sheet_(sheet), tree_(positions, own) {}

  /// Triangles that others are looked for at: those of the patch, then of the sheet.
  std::size_t size() const { return own_.size() + sheet_.size(); }

  std::vector<Contact> contacts(std::size_t begin, std::size_t end, std::uint64_t limit) const {
    std::vector<Contact> contacts;
    for (std::size_t i = begin; i < end; ++i) {
      const bool is_own = i < own_.size();
      const Triangle& t = is_own ? own_[i] : sheet_[i - own_.size()];
      const Box box = box_of(positions_, t);
      if (!box.intersects(tree_.box())) continue;
      const bool more = tree_.for_each(box, [&](std::uint32_t k) {
        if (is_own && k <= i) return true;
        if (triangles_intersect(positions_, own_[k], t))
          contacts.push_back({k, static_cast<std::uint32_t>(i)});
        return contacts.size() < limit;
      });
      if (!more) break;
    }
    return contacts;
  }

 private:
  std::span<const Vec3> positions_;
  std::span<const Triangle> own_, sheet_;
  BoxTree tree_;
};

}  // namespace

std::vector<Contact> find_contacts(const HoleProblem& problem, const HolePatch& patch,
                                   std::uint64_t limit) {
  std::vector<Vec3> positions = problem.positions;
  positions.insert(positions.end(), patch.positions.begin(), patch.positions.end());
  return find_contacts(positions, patch.triangles, problem.sheet, limit);
}

std::vector<Contact> find_contacts(std::span<const Vec3> positions, std::span<const Triangle> own,
                                   std::span<const Triangle> sheet, std::uint64_t limit) {
  if (own.empty() || limit == 0) return {};
  const ContactSearch search(positions, own, sheet);
  // Where all are wanted of many, by all threads: others wait for so large a hole.
  constexpr std::size_t kMany = 50'000;
  if (limit != UINT64_MAX || search.size() < kMany) return search.contacts(0, search.size(), limit);
  constexpr std::size_t kBlock = 4096;
  std::vector<std::vector<Contact>> blocks((search.size() + kBlock - 1) / kBlock);
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
      const std::size_t end = std::min((i + 1) * kBlock, search.size());
      blocks[i] = search.contacts(i * kBlock, end, UINT64_MAX);
    });
  });
  std::vector<Contact> contacts;
  for (const std::vector<Contact>& block : blocks)
    contacts.insert(contacts.end(), block.begin(), block.end());
  return contacts;
}

std::uint64_t count_intersections(const HoleProblem& problem, const HolePatch& patch,
                                  std::uint64_t limit) {
  return find_contacts(problem, patch, limit).size();
}

}  // namespace orbweave
