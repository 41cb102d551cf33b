#include "engine/stitching/mesh_summary.h"

#include <algorithm>

#include "engine/validation/boundary_loops.h"
#include "engine/validation/disjoint_sets.h"

namespace orbweave {

/// Every boundary edge leaves a fan at its tail and ends one at its head; the fan is its index.
std::uint64_t count_loops(std::span<const OpenFan> fans) {
  std::vector<OpenFan> arriving(fans.begin(), fans.end());
  std::sort(arriving.begin(), arriving.end());  // by (previous, vertex): the arriving edge
  std::vector<std::uint64_t> vertices;
  for (const OpenFan& fan : arriving) vertices.push_back(fan.vertex);
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  const auto number = [&](std::uint64_t vertex) {
    return static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), vertex) -
                                      vertices.begin());
  };
  std::vector<BoundaryEdge> edges;
  for (std::uint32_t fan = 0; fan < arriving.size(); ++fan) {
    const std::uint64_t vertex = arriving[fan].vertex, next = arriving[fan].next;
    const auto ended =
        std::lower_bound(arriving.begin(), arriving.end(), OpenFan{vertex, next, 0, 0});
    edges.push_back({{number(vertex), number(next)},
                     {fan, static_cast<std::uint32_t>(ended - arriving.begin())}});
  }
  return count_boundary_loops(edges);
}

void derive_facts(MeshFacts& facts) {
  const std::uint64_t edges = (3 * facts.triangles + facts.boundary_edges) / 2;
  facts.euler_characteristic = static_cast<std::int64_t>(facts.vertices) -
                               static_cast<std::int64_t>(edges) +
                               static_cast<std::int64_t>(facts.triangles);
  facts.watertight =
      facts.triangles > 0 && facts.boundary_edges == 0 && facts.nonmanifold_vertices == 0;
}

void MeshSummary::add(const ChunkMesh& chunk, std::uint64_t first_vertex, std::uint64_t triangles) {
  facts_.triangles += triangles;
  facts_.area += chunk.area;
  conflicts_lost_ += chunk.conflicts_lost;
  for (std::size_t i = 0; i < chunk.fans.size(); ++i) {
    facts_.vertices += chunk.fans[i] > 0 ? 1 : 0;
    unused_points_ += chunk.fans[i] > 0 ? 0 : 1;
    if (chunk.fans[i] > 1) boundary_.pinched.push_back(first_vertex + i);
  }
  const std::uint64_t before = boundary_.pieces.size();
  for (OpenFan fan : chunk.boundary) {
    fan.component += before;
    boundary_.fans.push_back(fan);
  }
  for (SeamNode node : chunk.seam) {
    node.component += before;
    seam_.push_back(node);
  }
  boundary_.vertices.insert(boundary_.vertices.end(), chunk.boundary_vertices.begin(),
                            chunk.boundary_vertices.end());
  boundary_.pieces.insert(boundary_.pieces.end(), chunk.pieces.begin(), chunk.pieces.end());
}

/// Pieces of different chunks are one where they share a node.
void MeshSummary::join_pieces() {
  std::sort(seam_.begin(), seam_.end());
  DisjointSets sets(boundary_.pieces.size());
  for (std::size_t i = 1; i < seam_.size(); ++i) {
    const SeamNode &a = seam_[i - 1], &b = seam_[i];
    if (a.vertex != b.vertex || a.fan != b.fan) continue;
    sets.unite(static_cast<std::uint32_t>(a.component), static_cast<std::uint32_t>(b.component));
  }
  seam_ = {};
  std::vector<ChunkPiece> joined;
  std::vector<std::uint64_t> number(boundary_.pieces.size());
  for (std::uint32_t p = 0; p < boundary_.pieces.size(); ++p) {
    const std::uint32_t root = sets.find(p);  // the first of its set
    if (root == p) {
      number[p] = joined.size();
      joined.emplace_back();
    }
    number[p] = number[root];
    const ChunkPiece& part = boundary_.pieces[p];
    ChunkPiece& whole = joined[number[p]];
    // Chunks come in canonical order: the first part that has a triangle has the smallest.
    if (whole.triangles == 0) whole.first = part.first;
    whole.triangles += part.triangles;
    whole.box.extend(part.box);
  }
  boundary_.pieces = std::move(joined);
  for (OpenFan& fan : boundary_.fans) fan.component = number[fan.component];
}

void MeshSummary::finish() {
  join_pieces();
  facts_.boundary_edges = boundary_.fans.size();
  facts_.boundary_loops = count_loops(boundary_.fans);
  facts_.components = boundary_.pieces.size();
  facts_.nonmanifold_vertices = boundary_.pinched.size();
  derive_facts(facts_);
}

}  // namespace orbweave
