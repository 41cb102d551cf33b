#include "engine/levels/soundness.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "engine/levels/corner_groups.h"
#include "engine/levels/marks.h"
#include "io/sort_unique.h"

namespace orbweave {
namespace {

/// An edge as a triangle runs through it, but for its lower vertex.
struct DirectedEdge {
  std::uint32_t high = 0;
  bool is_upward = false;  ///< from the lower vertex to the higher one
  friend auto operator<=>(const DirectedEdge&, const DirectedEdge&) = default;
};

void add_ends_of_unsound_edges(std::span<const Triangle> triangles,
                               std::vector<std::uint32_t>& unsound) {
  const auto from = [&](std::uint32_t t, std::size_t c) { return triangles[t][c]; };
  const auto to = [&](std::uint32_t t, std::size_t c) { return triangles[t][(c + 1) % 3]; };
  const CornerGroups<DirectedEdge> edges_of(
      triangles, [&](std::uint32_t t, std::size_t c) { return std::min(from(t, c), to(t, c)); },
      [&](std::uint32_t t, std::size_t c) {
        return DirectedEdge{std::max(from(t, c), to(t, c)), from(t, c) < to(t, c)};
      });
  for (std::uint32_t low = 0; low < edges_of.size(); ++low) {
    const std::span<const DirectedEdge> edges = edges_of[low];
    for (std::size_t i = 1; i < edges.size(); ++i) {
      const bool same_direction = edges[i] == edges[i - 1];
      const bool third = i > 1 && edges[i].high == edges[i - 2].high;
      if (!same_direction && !third) continue;
      unsound.push_back(low);
      unsound.push_back(edges[i].high);
    }
  }
}

/// What a triangle has beyond one of its vertices: an edge of the vertex's link.
struct LinkEdge {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  friend auto operator<=>(const LinkEdge&, const LinkEdge&) = default;
};

/// Whether the link of a vertex is one path or one cycle. Every vertex of the link begins at most
/// one edge and ends at most one; ascending by `from`. `ends`: used again for link after link.
bool is_one_fan(std::span<const LinkEdge> link, std::vector<std::uint32_t>& ends) {
  ends.clear();
  for (const LinkEdge& edge : link) ends.push_back(edge.to);
  std::sort(ends.begin(), ends.end());
  std::size_t first = 0;
  for (std::size_t i = 0; i < link.size(); ++i)
    if (!std::binary_search(ends.begin(), ends.end(), link[i].from)) first = i;
  std::size_t length = 1;
  for (std::size_t at = first; length <= link.size(); ++length) {
    const auto next =
        std::lower_bound(link.begin(), link.end(), link[at].to,
                         [](const LinkEdge& edge, std::uint32_t to) { return edge.from < to; });
    if (next == link.end() || next->from != link[at].to) break;
    at = static_cast<std::size_t>(next - link.begin());
    if (at == first) break;
  }
  return length == link.size();
}

void add_vertices_of_several_fans(std::span<const Triangle> triangles,
                                  std::vector<std::uint32_t>& unsound) {
  const CornerGroups<LinkEdge> links(
      triangles, [&](std::uint32_t t, std::size_t c) { return triangles[t][c]; },
      [&](std::uint32_t t, std::size_t c) {
        return LinkEdge{triangles[t][(c + 1) % 3], triangles[t][(c + 2) % 3]};
      });
  std::vector<std::uint32_t> ends;
  for (std::uint32_t vertex = 0; vertex < links.size(); ++vertex)
    if (!links[vertex].empty() && !is_one_fan(links[vertex], ends)) unsound.push_back(vertex);
}

}  // namespace

std::vector<std::uint32_t> unsound_vertices(std::span<const Triangle> triangles) {
  std::vector<std::uint32_t> unsound;
  add_ends_of_unsound_edges(triangles, unsound);
  add_vertices_of_several_fans(triangles, unsound);
  sort_unique(unsound);
  return unsound;
}

std::vector<EdgeEnds> edges_among(std::span<const Triangle> triangles,
                                  std::span<const std::uint32_t> vertices) {
  const Marks is_one(vertices);
  std::vector<EdgeEnds> edges;
  for (const Triangle& t : triangles) {
    const std::array<bool, 3> among = {is_one[t[0]], is_one[t[1]], is_one[t[2]]};
    for (std::size_t c = 0; c < 3; ++c)
      if (among[c] && among[(c + 1) % 3])
        edges.push_back({std::min(t[c], t[(c + 1) % 3]), std::max(t[c], t[(c + 1) % 3])});
  }
  sort_unique(edges);
  return edges;
}

}  // namespace orbweave
