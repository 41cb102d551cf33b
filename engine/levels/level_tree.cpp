#include "engine/levels/level_tree.h"

#include <algorithm>

#include "partition/root_cube.h"

namespace orbweave {
namespace {

/// How many codes a cell of that depth has.
std::uint64_t codes_of_cell(int depth) { return std::uint64_t{1} << (3 * (kMortonDepth - depth)); }

class TreeBuilder {
 public:
  TreeBuilder(const SortedTriangles& triangles, std::uint64_t most)
      : triangles_(triangles), most_(most) {}

  std::uint32_t add(LevelNode node) {
    std::vector<LevelNode> cells = cut(node);
    while (cells.size() == 1) {
      node = cells.front();
      cells = cut(node);
    }
    const auto number = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back(node);
    for (const LevelNode& cell : cells) {
      const std::uint32_t child = add(cell);
      nodes_[number].children.push_back(child);
      nodes_[number].height = std::max(nodes_[number].height, nodes_[child].height + 1);
    }
    return number;
  }
  std::vector<LevelNode> take() { return std::move(nodes_); }

 private:
  /// The occupied children of a cell; none where it is a leaf.
  std::vector<LevelNode> cut(const LevelNode& node) const {
    if (node.triangles <= most_ || node.depth == kMortonDepth) return {};
    std::vector<LevelNode> cells;
    const std::uint64_t end = node.first + node.triangles;
    std::uint64_t first = node.first;
    for (std::uint64_t octant = 0; octant < 8; ++octant) {
      const std::uint64_t code = node.code + octant * codes_of_cell(node.depth + 1);
      const std::uint64_t next =
          triangles_.first_at_least(code + codes_of_cell(node.depth + 1), first, end);
      if (next > first) cells.push_back({node.depth + 1, code, first, next - first, 0, {}});
      first = next;
    }
    return cells;
  }

  const SortedTriangles& triangles_;
  std::uint64_t most_;
  std::vector<LevelNode> nodes_;
};

}  // namespace

std::vector<LevelNode> level_tree(const SortedTriangles& triangles, std::uint64_t most_triangles) {
  TreeBuilder builder(triangles, most_triangles);
  builder.add({0, 0, 0, triangles.size(), 0, {}});
  return builder.take();
}

std::vector<std::vector<std::uint32_t>> nodes_by_height(const std::vector<LevelNode>& nodes) {
  std::vector<std::vector<std::uint32_t>> by_height(static_cast<std::size_t>(nodes.front().height) +
                                                    1);
  for (std::uint32_t i = 0; i < nodes.size(); ++i)
    by_height[static_cast<std::size_t>(nodes[i].height)].push_back(i);
  return by_height;
}

}  // namespace orbweave
