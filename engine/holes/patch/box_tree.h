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

/// A complete binary tree over boxes, those of triangles as a rule; every cut is at the median of
/// the centres.
class BoxTree {
 public:
  BoxTree(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
    list(positions, triangles);
    sort();
    extend(0, 0, items_.size());
  }

  explicit BoxTree(std::span<const Box> boxes) {
    list(boxes.size(), [&](std::size_t i) { return boxes[i]; });
    sort();
    extend(0, 0, items_.size());
  }

  /// For triangles whose neighbours are mostly near in their list, as those of a mesh in canonical
  /// order: they stay in that order, and are sorted only where that makes a poor tree.
  static BoxTree of_sheet(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
    BoxTree tree;
    tree.list(positions, triangles);
    tree.extend(0, 0, tree.items_.size());
    if (!tree.is_loose()) return tree;
    tree.sort();
    std::fill(tree.nodes_.begin(), tree.nodes_.end(), Box{});
    tree.extend(0, 0, tree.items_.size());
    return tree;
  }

  /// After vertices have moved; the triangles are the same. The cuts stay.
  void refit(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
    for (Item& item : items_) item.box = box_of(positions, triangles[item.triangle]);
    std::fill(nodes_.begin(), nodes_.end(), Box{});
    extend(0, 0, items_.size());
  }

  const Box& box() const { return nodes_[0]; }

  /// Calls visit(triangle number) for every triangle whose box meets `box` until it returns false.
  template <class Visit>
  bool for_each(const Box& box, const Visit& visit) const {
    return for_each(0, 0, items_.size(), box, visit);
  }
  /// Whether some box of the tree meets `box`.
  bool meets(const Box& box) const {
    return !for_each(box, [](std::uint32_t) { return false; });
  }

  /// The triangles whose boxes meet `box`, ascending.
  std::vector<std::uint32_t> near(const Box& box) const {
    std::vector<std::uint32_t> found;
    for_each(box, [&](std::uint32_t triangle) {
      found.push_back(triangle);
      return true;
    });
    if (!std::is_sorted(found.begin(), found.end())) std::sort(found.begin(), found.end());
    return found;
  }

 private:
  static constexpr std::size_t kLeafSize = 8;
  struct Item {
    Box box;
    std::uint32_t triangle = 0;
  };

  BoxTree() = default;

  /// Items in their order, and nodes that are empty.
  template <class BoxAt>
  void list(std::size_t count, const BoxAt& box_at) {
    items_.resize(count);
    for (std::size_t i = 0; i < count; ++i) items_[i] = {box_at(i), static_cast<std::uint32_t>(i)};
    std::size_t leaves = 1;
    while (leaves * kLeafSize < items_.size()) leaves *= 2;
    nodes_.resize(2 * leaves - 1);
  }
  void list(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
    list(triangles.size(), [&](std::size_t i) { return box_of(positions, triangles[i]); });
  }

  /// The sum of the sides, which flat boxes have, too.
  static double girth(const Box& box) {
    const Vec3 size = box.extent();
    return size.x + size.y + size.z;
  }

  /// Whether the leaves are much wider than the triangles in them.
  bool is_loose() const {
    constexpr double kLoose = 8.0;
    double of_items = 0.0, of_leaves = 0.0;
    for (const Item& item : items_) of_items += girth(item.box);
    for (std::size_t node = nodes_.size() / 2; node < nodes_.size(); ++node)
      of_leaves += girth(nodes_[node]);
    const std::size_t leaves = nodes_.size() - nodes_.size() / 2;
    const double per_leaf = static_cast<double>(items_.size()) / static_cast<double>(leaves);
    return of_leaves * per_leaf > kLoose * of_items;
  }

  void sort() {
    std::vector<Key> keys(items_.size());
    for (std::size_t i = 0; i < keys.size(); ++i)
      keys[i] = {items_[i].box.min + items_[i].box.max, items_[i].triangle};
    sort(0, keys);
    const std::vector<Item> before = items_;
    for (std::size_t i = 0; i < keys.size(); ++i) items_[i] = before[keys[i].triangle];
  }

  bool is_leaf(std::size_t node) const { return 2 * node + 1 >= nodes_.size(); }

  /// A triangle by its box's centre, doubled.
  struct Key {
    Vec3 center;
    std::uint32_t triangle = 0;
  };

  void sort(std::size_t node, std::span<Key> keys) {
    if (is_leaf(node)) return;
    Box centers;
    for (const Key& key : keys) centers.extend(key.center);
    const Vec3 size = centers.max - centers.min;
    const auto halve = [&](auto coordinate) {
      const std::size_t middle = keys.size() / 2;
      std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(middle), keys.end(),
                       [&](const Key& a, const Key& b) {
                         const double left = a.center.*coordinate, right = b.center.*coordinate;
                         return left != right ? left < right : a.triangle < b.triangle;
                       });
    };
    if (size.x >= size.y && size.x >= size.z) {
      halve(&Vec3::x);
    } else if (size.y >= size.z) {
      halve(&Vec3::y);
    } else {
      halve(&Vec3::z);
    }
    sort(2 * node + 1, keys.first(keys.size() / 2));
    sort(2 * node + 2, keys.subspan(keys.size() / 2));
  }

  void extend(std::size_t node, std::size_t begin, std::size_t end) {
    if (is_leaf(node)) {
      for (std::size_t i = begin; i < end; ++i) nodes_[node].extend(items_[i].box);
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    extend(2 * node + 1, begin, middle);
    extend(2 * node + 2, middle, end);
    nodes_[node].extend(nodes_[2 * node + 1]);
    nodes_[node].extend(nodes_[2 * node + 2]);
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
