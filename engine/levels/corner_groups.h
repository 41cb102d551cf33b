// What the corners of triangles have, grouped by vertices.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// One item of each corner, those of one vertex together and ascending: in linear time where few
/// items have the same vertex.
template <class Item>
class CornerGroups {
 public:
  /// `vertex_of` and `item_of` take the number of a triangle and that of a corner, 0 to 2. The
  /// vertex is one of the triangle's.
  template <class VertexOf, class ItemOf>
  CornerGroups(std::span<const Triangle> triangles, const VertexOf& vertex_of,
               const ItemOf& item_of) {
    std::uint32_t vertices = 0;
    for (const Triangle& t : triangles)
      vertices = std::max({vertices, t[0] + 1, t[1] + 1, t[2] + 1});
    ends_.assign(std::size_t{vertices} + 1, 0);
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) ++ends_[vertex_of(t, c) + 1];
    for (std::size_t v = 1; v < ends_.size(); ++v) ends_[v] += ends_[v - 1];
    items_.resize(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) items_[ends_[vertex_of(t, c)]++] = item_of(t, c);
    for (std::uint32_t v = 0; v < size(); ++v) {
      const std::span<Item> group = std::span(items_).subspan(first(v), ends_[v] - first(v));
      std::sort(group.begin(), group.end());
    }
  }

  std::uint32_t size() const { return static_cast<std::uint32_t>(ends_.size() - 1); }
  std::span<const Item> operator[](std::uint32_t vertex) const {
    return std::span(items_).subspan(first(vertex), ends_[vertex] - first(vertex));
  }

 private:
  std::size_t first(std::uint32_t vertex) const { return vertex == 0 ? 0 : ends_[vertex - 1]; }

  std::vector<std::size_t> ends_;  ///< of groups in `items_`
  std::vector<Item> items_;
};

}  // namespace orbweave
