// Which triangles may meet a box.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

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
    const std::vector<Box> boxes = boxes_of(positions, triangles);
    list(boxes.size());
    sort(boxes);
    extend(0, 0, numbers_.size(), boxes);
  }

  explicit BoxTree(std::span<const Box> boxes) {
    list(boxes.size());
    sort(boxes);
    extend(0, 0, numbers_.size(), boxes);
  }

  /// For triangles whose neighbours are mostly near in their list, as those of a mesh in canonical
  /// order: they stay in that order, and are sorted only where that makes a poor tree.
  static BoxTree of_sheet(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
    BoxTree tree;
    const std::vector<Box> boxes = boxes_of(positions, triangles);
    tree.list(boxes.size());
    tree.extend(0, 0, boxes.size(), boxes);
    if (!tree.is_loose(boxes)) return tree;
    tree.sort(boxes);
    tree.extend(0, 0, boxes.size(), boxes);
    return tree;
  }

  /// After vertices have moved; the triangles are the same. The cuts stay.
  void refit(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
    extend(0, 0, numbers_.size(), boxes_of(positions, triangles));
  }

  const Box& box() const { return nodes_[0]; }

  /// Calls visit(triangle number) for every triangle whose box meets `box` until it returns false.
  template <class Visit>
  bool for_each(const Box& box, const Visit& visit) const {
    return for_each(0, 0, numbers_.size(), box, visit);
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
  /// The boxes of a leaf, a list of each bound.
  struct Leaf {
    std::array<std::array<double, kLeafSize>, 3> min, max;

    void set(std::size_t place, const Box& box) {
      for (int axis = 0; axis < 3; ++axis) {
        min[axis][place] = box.min[axis];
        max[axis][place] = box.max[axis];
      }
    }
    /// Bit i: box i meets `box`.
    std::uint32_t meeting(const Box& box) const {
      std::uint32_t found = 0;
#ifdef __SSE2__
      for (std::size_t i = 0; i < kLeafSize; i += 2) {
        __m128d meets = _mm_castsi128_pd(_mm_set1_epi64x(-1));
        for (int axis = 0; axis < 3; ++axis) {
          const __m128d low = _mm_loadu_pd(&min[axis][i]), high = _mm_loadu_pd(&max[axis][i]);
          meets = _mm_and_pd(meets, _mm_cmple_pd(low, _mm_set1_pd(box.max[axis])));
          meets = _mm_and_pd(meets, _mm_cmple_pd(_mm_set1_pd(box.min[axis]), high));
        }
        found |= static_cast<std::uint32_t>(_mm_movemask_pd(meets)) << i;
      }
#else
      for (std::size_t i = 0; i < kLeafSize; ++i) {
        bool meets = true;
        for (int axis = 0; axis < 3; ++axis)
          meets &= min[axis][i] <= box.max[axis] && box.min[axis] <= max[axis][i];
        found |= static_cast<std::uint32_t>(meets) << i;
      }
#endif
      return found;
    }
  };

  BoxTree() = default;

  static std::vector<Box> boxes_of(std::span<const Vec3> positions,
                                   std::span<const Triangle> triangles) {
    std::vector<Box> boxes(triangles.size());
    for (std::size_t i = 0; i < boxes.size(); ++i)
      boxes[i] = orbweave::box_of(positions, triangles[i]);
    return boxes;
  }

  /// Numbers in their order, and room for the nodes.
  void list(std::size_t count) {
    numbers_.resize(count);
    for (std::size_t i = 0; i < count; ++i) numbers_[i] = static_cast<std::uint32_t>(i);
    std::size_t leaves = 1;
    while (leaves * kLeafSize < count) leaves *= 2;
    nodes_.resize(2 * leaves - 1);
    leaves_.resize(leaves);
  }

  /// The sum of the sides, which flat boxes have, too.
  static double girth(const Box& box) {
    const Vec3 size = box.extent();
    return size.x + size.y + size.z;
  }

  /// Whether the leaves are much wider than the triangles in them.
  bool is_loose(std::span<const Box> boxes) const {
    constexpr double kLoose = 8.0;
    double of_items = 0.0, of_leaves = 0.0;
    for (const Box& box : boxes) of_items += girth(box);
    for (std::size_t node = nodes_.size() / 2; node < nodes_.size(); ++node)
      of_leaves += girth(nodes_[node]);
    const double per_leaf = static_cast<double>(boxes.size()) / static_cast<double>(leaves_.size());
    return of_leaves * per_leaf > kLoose * of_items;
  }

  void sort(std::span<const Box> boxes) {
    if (is_leaf(0)) return;
    std::vector<Key> keys(boxes.size());
    for (std::size_t i = 0; i < keys.size(); ++i)
      keys[i] = {boxes[i].min + boxes[i].max, static_cast<std::uint32_t>(i)};
    sort(0, keys);
    for (std::size_t i = 0; i < keys.size(); ++i) numbers_[i] = keys[i].triangle;
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

  /// `boxes`: by number.
  void extend(std::size_t node, std::size_t begin, std::size_t end, std::span<const Box> boxes) {
    nodes_[node] = {};
    if (is_leaf(node)) {
      Leaf& leaf = leaves_[node - nodes_.size() / 2];
      for (std::size_t i = begin; i < end; ++i) {
        const Box& box = boxes[numbers_[i]];
        nodes_[node].extend(box);
        leaf.set(i - begin, box);
      }
      for (std::size_t place = end - begin; place < kLeafSize; ++place) leaf.set(place, {});
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    extend(2 * node + 1, begin, middle, boxes);
    extend(2 * node + 2, middle, end, boxes);
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
    for (std::uint32_t found = leaves_[node - nodes_.size() / 2].meeting(box); found != 0;
         found &= found - 1) {
      if (!visit(numbers_[begin + static_cast<std::size_t>(std::countr_zero(found))])) return false;
    }
    return true;
  }

  std::vector<std::uint32_t> numbers_;  ///< of the boxes, leaf by leaf
  std::vector<Leaf> leaves_;
  std::vector<Box> nodes_;
};

}  // namespace orbweave
