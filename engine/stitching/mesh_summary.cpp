#include "engine/stitching/mesh_summary.h"

#include <algorithm>

#include "engine/validation/boundary_loops.h"
#include "engine/validation/disjoint_sets.h"

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

/// Every boundary edge leaves a fan at its tail and ends one at its head; the fan is its index.
std::uint64_t MeshSummary::count_loops() {
  std::sort(boundary_.begin(), boundary_.end());  // by (previous, vertex): the arriving edge
  std::vector<std::uint64_t> vertices;
  for (const Triangle64& fan : boundary_) vertices.push_back(fan[1]);
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const auto number = [&](std::uint64_t vertex) {
    return static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), vertex) -
                                      vertices.begin());
  };
  std::vector<BoundaryEdge> edges;
  for (std::uint32_t fan = 0; fan < boundary_.size(); ++fan) {
    const std::uint64_t vertex = boundary_[fan][1], next = boundary_[fan][2];
    const Triangle64 leaving{vertex, next, 0};
    const auto ended = std::lower_bound(boundary_.begin(), boundary_.end(), leaving);
    edges.push_back({{number(vertex), number(next)},
                     {fan, static_cast<std::uint32_t>(ended - boundary_.begin())}});
  }
  return count_boundary_loops(edges);
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
