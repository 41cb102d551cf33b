#include "engine/stitching/mesh_summary.h"

#include <algorithm>

#include "engine/stitching/disjoint_sets.h"

namespace orbweave {

void MeshSummary::add(const ChunkMesh& chunk, std::uint64_t triangles) {
  facts_.triangles += triangles;
  facts_.area += chunk.area;
  conflicts_lost_ += chunk.conflicts_lost;
  for (const std::uint8_t fans : chunk.fans) {
    facts_.vertices += fans > 0 ? 1 : 0;
    unused_points_ += fans > 0 ? 0 : 1;
    facts_.nonmanifold_vertices += fans > 1 ? 1 : 0;
  }
  boundary_.insert(boundary_.end(), chunk.boundary.begin(), chunk.boundary.end());
  for (SeamNode node : chunk.seam) {
    node.component += components_;
    seam_.push_back(node);
  }
  components_ += chunk.components;
}

/// Components of different chunks are one where they share a node.
std::uint64_t MeshSummary::count_components() {
  std::sort(seam_.begin(), seam_.end());
  DisjointSets sets(components_);
  for (std::size_t i = 1; i < seam_.size(); ++i) {
    const SeamNode &a = seam_[i - 1], &b = seam_[i];
    if (a.vertex != b.vertex || a.fan != b.fan) continue;
    sets.unite(static_cast<std::uint32_t>(a.component), static_cast<std::uint32_t>(b.component));
  }
  std::uint64_t roots = 0;
  for (std::uint32_t c = 0; c < components_; ++c) roots += sets.find(c) == c ? 1 : 0;
  return roots;
}

/// Every boundary edge arrives at one vertex and leaves it within the same fan: cycles.
std::uint64_t MeshSummary::count_loops() {
  std::sort(boundary_.begin(), boundary_.end());  // by (previous, vertex): the arriving edge
  std::vector<std::uint8_t> seen(boundary_.size(), 0);
  std::uint64_t loops = 0;
  for (std::size_t start = 0; start < boundary_.size(); ++start) {
    if (seen[start] != 0) continue;
    ++loops;
    for (std::size_t at = start; at < boundary_.size() && seen[at] == 0;) {
      seen[at] = 1;
      const Triangle64 leaving{boundary_[at][1], boundary_[at][2], 0};
      at = static_cast<std::size_t>(std::lower_bound(boundary_.begin(), boundary_.end(), leaving) -
                                    boundary_.begin());
    }
  }
  return loops;
}

MeshFacts MeshSummary::facts() {
  MeshFacts facts = facts_;
  facts.boundary_edges = boundary_.size();
  facts.boundary_loops = count_loops();
  facts.components = count_components();
  const std::uint64_t edges = (3 * facts.triangles + facts.boundary_edges) / 2;
  facts.euler_characteristic = static_cast<std::int64_t>(facts.vertices) -
                               static_cast<std::int64_t>(edges) +
                               static_cast<std::int64_t>(facts.triangles);
  facts.watertight =
      facts.triangles > 0 && facts.boundary_edges == 0 && facts.nonmanifold_vertices == 0;
  return facts;
}

}  // namespace orbweave
