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
  BoxTree(std::span<const Vec3> positions, std::span<const Triangle> triangles)
      : BoxTree(boxes_of(positions, triangles)) {}
  explicit BoxTree(std::span<const Box> boxes) {
    std::vector<Key> keys(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i)
      keys[i] = {boxes[i].min + boxes[i].max, static_cast<std::uint32_t>(i)};
    std::size_t leaves = 1;
    while (leaves * kLeafSize < keys.size()) leaves *= 2;
    nodes_.resize(2 * leaves - 1);
    sort(0, keys);
    items_.reserve(keys.size());
    for (const Key& key : keys) items_.push_back({boxes[key.triangle], key.triangle});
    extend(0, 0, items_.size());
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

 private:
  static std::vector<Box> boxes_of(std::span<const Vec3> positions,
                                   std::span<const Triangle> triangles) {
    std::vector<Box> boxes;
    boxes.reserve(triangles.size());
    for (const Triangle& t : triangles) boxes.push_back(box_of(positions, t));
    return boxes;
  }

  static constexpr std::size_t kLeafSize = 8;
  struct Item {
    Box box;
    std::uint32_t triangle = 0;
  };

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
