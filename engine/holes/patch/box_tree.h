// Which triangles may meet a box.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/box.h"
#include "io/triangle_mesh.h"

namespace orbweave {

inline Box box_of(std::span<const Vec3> positions, const Triangle& t) {
  Box box;
  for (const std::uint32_t v : t) box.extend(positions[v]);
  return box;
}

/// A complete binary tree over the boxes of triangles; every cut is at the median of the centres.
class BoxTree {
 public:
  BoxTree(std::span<const Vec3> positions, std::span<const Triangle> triangles)
      : items_(triangles.size()) {
    for (std::size_t i = 0; i < triangles.size(); ++i)
      items_[i] = {box_of(positions, triangles[i]), static_cast<std::uint32_t>(i)};
    std::size_t leaves = 1;
    while (leaves * kLeafSize < items_.size()) leaves *= 2;
    nodes_.resize(2 * leaves - 1);
    build(0, 0, items_.size());
  }

  const Box& box() const { return nodes_[0]; }

  /// Calls visit(triangle number) for every triangle whose box meets `box` until it returns false.
  template <class Visit>
  bool for_each(const Box& box, const Visit& visit) const {
    return for_each(0, 0, items_.size(), box, visit);
  }

 private:
  static constexpr std::size_t kLeafSize = 8;
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

}  // namespace orbweave
