#include "engine/holes/patch/patch_defect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/holes/patch/loop_edges.h"

namespace orbweave {
namespace {

using Edge = std::array<std::uint32_t, 2>;

Edge undirected(Edge edge) {
  if (edge[1] < edge[0]) std::swap(edge[0], edge[1]);
  return edge;
}

std::string text_of(Edge edge) {
  return "edge " + std::to_string(edge[0]) + "-" + std::to_string(edge[1]);
}

std::vector<Edge> edges_of(const std::vector<Triangle>& triangles) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    edges.insert(edges.end(), {Edge{t[0], t[1]}, Edge{t[1], t[2]}, Edge{t[2], t[0]}});
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

bool contains(const std::vector<Edge>& sorted, Edge edge) {
  return std::binary_search(sorted.begin(), sorted.end(), edge);
}

std::string array_defect(const HoleProblem& problem, const HolePatch& patch) {
  const std::size_t n = patch.positions.size();
  if (patch.normals.size() != n) return "not one normal per new vertex";
  if (patch.values.size() != n * problem.channels) return "not all values per new vertex";
  if (!std::all_of(patch.positions.begin(), patch.positions.end(), is_finite)) {
    return "a position that is not finite";
  }
  if (!std::all_of(patch.normals.begin(), patch.normals.end(), is_finite)) {
    return "a normal that is not finite";
  }
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::all_of(patch.values.begin(), patch.values.end(), finite)) {
    return "a value that is not finite";
  }
  return "";
}

std::string index_defect(const HoleProblem& problem, const HolePatch& patch) {
  const std::size_t given = problem.positions.size();
  std::vector<char> known(given + patch.positions.size(), 0);
  for (std::size_t v = given; v < known.size(); ++v) known[v] = 1;
  for (const std::uint32_t v : problem.loop) known[v] = 1;
  std::vector<char> used(known.size(), 0);
  for (const Triangle& t : patch.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return "a triangle with equal corners";
    for (const std::uint32_t v : t) {
      if (v >= known.size()) return "vertex " + std::to_string(v) + " does not exist";
      if (known[v] == 0) return "vertex " + std::to_string(v) + " is not on the rim";
      used[v] = 1;
    }
  }
  for (std::size_t v = given; v < used.size(); ++v) {
    if (used[v] == 0) return "new vertex " + std::to_string(v - given) + " is not used";
  }
  return "";
}

/// Edges of the sheet between corners of the loop: the only ones that a patch can repeat.
std::vector<Edge> sheet_edges_along(const HoleProblem& problem) {
  std::vector<char> is_corner(problem.positions.size(), 0);
  for (const std::uint32_t v : problem.loop) is_corner[v] = 1;
  std::vector<Edge> edges;
  for (const Triangle& t : problem.sheet) {
    if (is_corner[t[0]] + is_corner[t[1]] + is_corner[t[2]] < 2) continue;
    for (int k = 0; k < 3; ++k) {
      const Edge edge = {t[k], t[(k + 1) % 3]};
      if (is_corner[edge[0]] != 0 && is_corner[edge[1]] != 0) edges.push_back(edge);
    }
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// Rim edges once and in the loop's direction, edges inside once in each, and so those that the
/// loop runs along both ways.
std::string edge_defect(const HoleProblem& problem, const std::vector<Edge>& edges,
                        const std::vector<Edge>& rim) {
  const std::vector<Edge> sheet = sheet_edges_along(problem);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Edge edge = edges[i];
    const Edge reverse = {edge[1], edge[0]};
    if (i > 0 && edges[i - 1] == edge) return text_of(edge) + " is used twice in one direction";
    const bool on_rim = contains(rim, edge);
    const bool on_reverse = contains(rim, reverse);
    const bool inside = contains(edges, reverse);
    if (on_reverse && !on_rim) return text_of(edge) + " runs against the loop";
    if (!inside && (!on_rim || on_reverse))
      return text_of(edge) + " is a boundary that is not the loop's";
    if (on_rim) continue;
    if (std::binary_search(problem.forbidden.begin(), problem.forbidden.end(), undirected(edge))) {
      return text_of(edge) + " is forbidden";
    }
    if (contains(sheet, edge) || contains(sheet, reverse)) {
      return text_of(edge) + " is in the sheet already";
    }
  }
  for (const Edge& edge : rim) {
    // What the loop runs along both ways is no boundary: it may have been cut.
    if (contains(rim, {edge[1], edge[0]})) continue;
    if (!contains(edges, edge)) return "rim " + text_of(edge) + " stays open";
  }
  return "";
}

/// A triangle's corner, with the edge to the next corner and the edge from the one before.
struct Wedge {
  std::uint32_t vertex, next, previous;
};

std::vector<Wedge> sorted_wedges(const std::vector<Triangle>& triangles) {
  std::vector<Wedge> wedges;
  wedges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) wedges.push_back({t[k], t[(k + 1) % 3], t[(k + 2) % 3]});
  }
  std::sort(wedges.begin(), wedges.end(), [](const Wedge& a, const Wedge& b) {
    return std::pair(a.vertex, a.next) < std::pair(b.vertex, b.next);
  });
  return wedges;
}

struct Fans {
  std::size_t open = 0;
  std::size_t closed = 0;
};

/// Fans of the wedges [first, last), all of one vertex, whose edges are sound: every wedge has at
/// most one to its left.
Fans count_fans(const Wedge* first, const Wedge* last) {
  const auto left_of = [&](const Wedge& wedge) {
    const Wedge* found =
        std::lower_bound(first, last, wedge.previous,
                         [](const Wedge& other, std::uint32_t next) { return other.next < next; });
    return found != last && found->next == wedge.previous ? found : nullptr;
  };
  const auto n = static_cast<std::size_t>(last - first);
  std::vector<char> has_right(n, 0), seen(n, 0);
  for (const Wedge* w = first; w != last; ++w) {
    if (const Wedge* left = left_of(*w)) has_right[left - first] = 1;
  }
  Fans fans;
  const auto follow = [&](std::size_t i) {
    for (const Wedge* w = first + i; w != nullptr && seen[w - first] == 0; w = left_of(*w)) {
      seen[w - first] = 1;
    }
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (has_right[i] != 0) continue;
    ++fans.open;
    follow(i);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (seen[i] != 0) continue;
    ++fans.closed;
    follow(i);
  }
  return fans;
}

/// New vertices have one closed fan. Vertices of the rim have open ones, but for those all of
/// whose edges in the loop are inside (the end of a slit), which have one closed one.
std::string fan_defect(const HoleProblem& problem, const HolePatch& patch,
                       const std::vector<Edge>& rim) {
  std::vector<char> open(problem.positions.size(), 0);
  for (const Edge& edge : rim) {
    if (!contains(rim, {edge[1], edge[0]})) open[edge[0]] = open[edge[1]] = 1;
  }
  const std::vector<Wedge> wedges = sorted_wedges(patch.triangles);
  for (std::size_t i = 0, j = 0; i < wedges.size(); i = j) {
    const std::uint32_t vertex = wedges[i].vertex;
    while (j < wedges.size() && wedges[j].vertex == vertex) ++j;
    const Fans fans = count_fans(wedges.data() + i, wedges.data() + j);
    const bool on_rim = vertex < open.size() && open[vertex] != 0;
    if (on_rim ? fans.closed > 0 : fans.closed != 1) {
      return "vertex " + std::to_string(vertex) + " has several fans";
    }
  }
  return "";
}

/// Every piece of the patch reaches the rim.
std::string piece_defect(const HoleProblem& problem, const HolePatch& patch) {
  const std::size_t given = problem.positions.size();
  std::vector<std::uint32_t> parent(given + patch.positions.size());
  for (std::uint32_t v = 0; v < parent.size(); ++v) parent[v] = v;
  const auto root = [&](std::uint32_t v) {
    for (; parent[v] != v; v = parent[v]) parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : patch.triangles) {
    for (const std::uint32_t v : {t[1], t[2]}) {
      // The smaller one is the root, so that a piece at the rim has its root there.
      const auto [low, high] = std::minmax({root(t[0]), root(v)});
      parent[high] = low;
    }
  }
  for (std::uint32_t v = static_cast<std::uint32_t>(given); v < parent.size(); ++v) {
    if (root(v) >= given) return "a piece that does not touch the rim";
  }
  return "";
}

}  // namespace

std::string patch_defect(const HoleProblem& problem, const HolePatch& patch) {
  if (patch.method == FillMethod::kNone) {
    const bool empty = patch.triangles.empty() && patch.positions.empty();
    return empty ? "" : "triangles of a hole that stays open";
  }
  if (std::string defect = array_defect(problem, patch); !defect.empty()) return defect;
  if (std::string defect = index_defect(problem, patch); !defect.empty()) return defect;
  const std::vector<Edge> rim = edges_of_loop(problem.loop);
  const std::vector<Edge> edges = edges_of(patch.triangles);
  if (std::string defect = edge_defect(problem, edges, rim); !defect.empty()) return defect;
  if (std::string defect = fan_defect(problem, patch, rim); !defect.empty()) return defect;
  return piece_defect(problem, patch);
}

}  // namespace orbweave
