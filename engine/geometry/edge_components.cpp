#include "engine/geometry/edge_components.h"

#include <algorithm>
#include <tuple>

namespace orbweave {
namespace {

/// An edge of a triangle, the smaller vertex first.
struct EdgeUse {
  std::uint32_t lower = 0, upper = 0, triangle = 0;
  friend auto operator<=>(const EdgeUse&, const EdgeUse&) = default;
};

std::vector<EdgeUse> sorted_edges(std::span<const Triangle> triangles) {
  std::vector<EdgeUse> edges;
  edges.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), t});
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// The components of a part, numbered by their first triangles.
struct PartComponents {
  std::vector<std::uint32_t> of_triangle;
  std::uint32_t count = 0;
  std::vector<EdgeUse> single;  ///< edges of one triangle
};

PartComponents components_of(std::span<const Triangle> triangles) {
  PartComponents part;
  part.single = sorted_edges(triangles);
  DisjointSets sets(triangles.size());
  std::size_t kept = 0;
  for (std::size_t begin = 0, end = 0; begin < part.single.size(); begin = end) {
    const EdgeUse edge = part.single[begin];
    for (end = begin + 1; end < part.single.size() && part.single[end].lower == edge.lower &&
                          part.single[end].upper == edge.upper;
         ++end)
      sets.unite(edge.triangle, part.single[end].triangle);
    if (end == begin + 1) part.single[kept++] = edge;
  }
  part.single.resize(kept);
  part.of_triangle.resize(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const std::uint32_t root = sets.find(t);  // the first of its set
    part.of_triangle[t] = root == t ? part.count++ : part.of_triangle[root];
  }
  return part;
}

}  // namespace

void EdgeComponents::add(std::span<const Triangle> triangles, const GlobalVertex& global) {
  constexpr std::size_t kLeastJoined = std::size_t{1} << 16;
  const PartComponents part = components_of(triangles);
  const auto first = static_cast<std::uint32_t>(sets_.size());
  first_.push_back(first);
  for (std::uint32_t c = 0; c < part.count; ++c) sets_.add();
  sizes_.resize(sets_.size(), 0);
  for (const std::uint32_t component : part.of_triangle) ++sizes_[first + component];
  for (const EdgeUse& edge : part.single) {
    const std::uint64_t a = global(edge.lower), b = global(edge.upper);
    open_.push_back({std::min(a, b), std::max(a, b), first + part.of_triangle[edge.triangle]});
  }
  if (open_.size() <= join_at_) return;
  join_open_edges();
  join_at_ = std::max(kLeastJoined, 2 * open_.size());
}

/// Joins components that share an edge; such edges have all of their triangles then and go.
void EdgeComponents::join_open_edges() {
  std::sort(open_.begin(), open_.end());
  std::size_t kept = 0;
  for (std::size_t begin = 0, end = 0; begin < open_.size(); begin = end) {
    const OpenEdge edge = open_[begin];
    for (end = begin + 1;
         end < open_.size() && open_[end].lower == edge.lower && open_[end].upper == edge.upper;
         ++end)
      sets_.unite(edge.component, open_[end].component);
    if (end == begin + 1) open_[kept++] = edge;
  }
  open_.resize(kept);
}

void EdgeComponents::finish() {
  join_open_edges();
  open_ = {};
  std::vector<std::uint32_t> roots;
  for (std::uint32_t c = 0; c < sizes_.size(); ++c) {
    const std::uint32_t root = sets_.find(c);  // the first of its set
    if (root == c)
      roots.push_back(c);
    else
      sizes_[root] += sizes_[c];
  }
  std::ranges::stable_sort(roots,
                           [&](std::uint32_t a, std::uint32_t b) { return sizes_[a] > sizes_[b]; });
  rank_.resize(sizes_.size());
  for (std::uint32_t rank = 0; rank < roots.size(); ++rank) {
    rank_[roots[rank]] = rank;
    triangles_.push_back(sizes_[roots[rank]]);
  }
  for (std::uint32_t c = 0; c < sizes_.size(); ++c) rank_[c] = rank_[sets_.find(c)];
}

std::vector<std::uint32_t> EdgeComponents::ranks(std::size_t part,
                                                 std::span<const Triangle> triangles) const {
  std::vector<std::uint32_t> ranks = components_of(triangles).of_triangle;
  for (std::uint32_t& rank : ranks) rank = rank_[first_[part] + rank];
  return ranks;
}

}  // namespace orbweave
