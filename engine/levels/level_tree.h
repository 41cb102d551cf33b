// The octree of levels of detail: leaves of at most a fixed number of triangles.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/levels/sorted_triangles.h"

namespace orbweave {

/// A node: the triangles whose codes begin like that of its cell, one range of the sorted ones.
struct LevelNode {
  int depth = 0;                        ///< of its cell; 0: the root cube
  std::uint64_t code = 0;               ///< of the cell's first finest cell
  std::uint64_t first = 0;              ///< of its triangles
  std::uint64_t triangles = 0;          ///< of the mesh that lie in the cell
  int height = 0;                       ///< 0: a leaf; else one more than the highest child
  std::vector<std::uint32_t> children;  ///< by their codes; never a single one
  bool is_leaf() const { return children.empty(); }
};

/// All nodes, every one before its children, children of one node in the order of their codes; the
/// root first. A cell is cut where it has more than `most_triangles` triangles and is not the
/// finest; cells with one occupied child give way to that child. So the tree depends on the
/// triangles' codes alone. Precondition: there is a triangle.
std::vector<LevelNode> level_tree(const SortedTriangles& triangles, std::uint64_t most_triangles);

/// Numbers of the nodes of each height, ascending: leaves first.
std::vector<std::vector<std::uint32_t>> nodes_by_height(const std::vector<LevelNode>& nodes);

}  // namespace orbweave
