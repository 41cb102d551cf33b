#include "engine/holes/patch/patch_intersections.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "engine/geometry/triangle_intersection.h"
#include "io/box.h"

namespace orbweave {
namespace {

/// A complete binary tree over the boxes of triangles; every cut is at the median of the centres.
class BoxTree {
 public:
  BoxTree(std::span<const Vec3> positions, std::span<const Triangle> triangles)
      : items_(triangles.size()) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      items_[i].triangle = static_cast<std::uint32_t>(i);
      for (const std::uint32_t v : triangles[i]) items_[i].box.extend(positions[v]);
    }
    std::size_t leaves = 1;
    while (leaves * kLeafSize < items_.size()) leaves *= 2;
    nodes_.resize(2 * leaves - 1);
    build(0, 0, items_.size());
  }

  const Box& box() const { return nodes_[0]; }

  /// Calls visit(triangle) for every triangle whose box meets `box` until it returns false.
  template <class Visit>
  bool for_each(const Box& box, const Visit& visit) const {
    return for_each(0, 0, items_.size(), box, visit);
  }

 private:
  static constexpr std::size_t kLeafSize = 4;
  struct Item {
    Box box;
    std::uint32_t triangle = 0;
  };

  bool is_leaf(std::size_t node) const { return 2 * node + 1 >= nodes_.size(); }

  void build(std::size_t node, std::size_t begin, std::size_t end) {
    Box centers;
    for (std::size_t i = begin; i < end; ++i) {
      nodes_[node].extend(items_[i].box);
      centers.extend(items_[i].box.min + items_[i].box.max);
    }
    if (is_leaf(node)) return;
    const Vec3 size = centers.max - centers.min;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto at = [&](std::size_t i) { return items_.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(at(begin), at(middle), at(end), [axis](const Item& a, const Item& b) {
      const double left = a.box.min[axis] + a.box.max[axis];
      const double right = b.box.min[axis] + b.box.max[axis];
      return left != right ? left < right : a.triangle < b.triangle;
    });
    build(2 * node + 1, begin, middle);
    build(2 * node + 2, middle, end);
  }

  template <class Visit>
  bool for_each(std::size_t node, std::size_t begin, std::size_t end, const Box& box,
                const Visit& visit) const {
    if (begin == end || !nodes_[node].intersects(box)) return true;
    if (!is_leaf(node)) {
      const std::size_t middle = begin + (end - begin) / 2;
      return for_each(2 * node + 1, begin, middle, box, visit) &&
             for_each(2 * node + 2, middle, end, box, visit);
    }
    for (std::size_t i = begin; i < end; ++i) {
      if (items_[i].box.intersects(box) && !visit(items_[i].triangle)) return false;
    }
    return true;
  }

  std::vector<Item> items_;
  std::vector<Box> nodes_;
};

Box box_of(std::span<const Vec3> positions, const Triangle& t) {
  Box box;
  for (const std::uint32_t v : t) box.extend(positions[v]);
  return box;
}

}  // namespace

std::vector<Contact> find_contacts(const HoleProblem& problem, const HolePatch& patch,
                                   std::uint64_t limit) {
  std::vector<Contact> contacts;
  if (patch.triangles.empty() || limit == 0) return contacts;
  std::vector<Vec3> positions = problem.positions;
  positions.insert(positions.end(), patch.positions.begin(), patch.positions.end());
  const std::vector<Triangle>& own = patch.triangles;
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
  for (const Triangle& t : problem.sheet) {
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
