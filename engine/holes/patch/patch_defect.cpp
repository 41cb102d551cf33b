#include "engine/holes/patch/patch_defect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/geometry/vertex_groups.h"
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

/// The corners of a patch's triangles by vertex, and with them its directed edges, sorted.
class PatchCorners {
 public:
  /// A triangle's corner at a vertex: the edge to `next` and that from `previous`.
  struct Corner {
    std::uint32_t next = 0, previous = 0;
  };

  PatchCorners(const std::vector<Triangle>& triangles, std::size_t vertices)
      : first_(vertices + 1, 0), corners_(3 * triangles.size()) {
    for (const Triangle& t : triangles)
      for (const std::uint32_t v : t) ++first_[v + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<std::uint32_t> place(first_.begin(), first_.end() - 1);
    for (const Triangle& t : triangles)
      for (int k = 0; k < 3; ++k) corners_[place[t[k]]++] = {t[(k + 1) % 3], t[(k + 2) % 3]};
    for (std::size_t v = 0; v < vertices; ++v)
      std::sort(corners_.begin() + first_[v], corners_.begin() + first_[v + 1],
                [](const Corner& a, const Corner& b) { return a.next < b.next; });
  }

  std::uint32_t vertices() const { return static_cast<std::uint32_t>(first_.size() - 1); }
  std::span<const Corner> at(std::uint32_t vertex) const {
    return std::span(corners_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }
  bool has(Edge edge) const { return find(at(edge[0]), edge[1]) != nullptr; }

  /// The corner of a vertex with the edge to `next`; null where there is none.
  static const Corner* find(std::span<const Corner> corners, std::uint32_t next) {
    constexpr std::size_t kFew = 16;
    if (corners.size() > kFew) {
      const auto found =
          std::lower_bound(corners.begin(), corners.end(), next,
                           [](const Corner& a, std::uint32_t other) { return a.next < other; });
      return found != corners.end() && found->next == next ? &*found : nullptr;
    }
    for (const Corner& corner : corners)
      if (corner.next == next) return &corner;
    return nullptr;
  }

 private:
  std::vector<std::uint32_t> first_;  // per vertex, and one past the last
  std::vector<Corner> corners_;
};

bool contains(const std::vector<Edge>& sorted, Edge edge) {
  return std::binary_search(sorted.begin(), sorted.end(), edge);
}

std::string array_defect(const HoleProblem& problem, const HolePatch& patch) {
  const std::size_t n = patch.positions.size();
  if (patch.normals.size() != n) return "not one normal per new vertex";
  if (patch.values.size() != (patch.lacks_values ? 0 : n * problem.channels))
    return "not all values per new vertex";
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
std::vector<Edge> sheet_edges_along(const HoleProblem& problem,
                                    std::span<const Triangle> rim_faces) {
  std::vector<char> is_corner(problem.positions.size(), 0);
  for (const std::uint32_t v : problem.loop) is_corner[v] = 1;
  std::vector<Edge> edges;
  for (const Triangle& t : rim_faces) {
    if (is_corner[t[0]] + is_corner[t[1]] + is_corner[t[2]] < 2) continue;
    for (int k = 0; k < 3; ++k) {
      const Edge edge = {t[k], t[(k + 1) % 3]};
      if (is_corner[edge[0]] != 0 && is_corner[edge[1]] != 0) edges.push_back(edge);
    }
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// What is known of edges between given vertices: only these can be of the rim, forbidden or in
/// the sheet.
struct GivenEdges {
  std::vector<Edge> rim, sheet;  ///< sorted
};

std::string given_edge_defect(const HoleProblem& problem, const GivenEdges& known, Edge edge,
                              bool is_inside) {
  const Edge reverse = {edge[1], edge[0]};
  const bool on_rim = contains(known.rim, edge);
  const bool on_reverse = contains(known.rim, reverse);
  if (on_reverse && !on_rim) return text_of(edge) + " runs against the loop";
  if (!is_inside && (!on_rim || on_reverse))
    return text_of(edge) + " is a boundary that is not the loop's";
  if (on_rim) return {};
  if (std::binary_search(problem.forbidden.begin(), problem.forbidden.end(), undirected(edge)) ||
      share_a_group(problem.apart, edge[0], edge[1]))
    return text_of(edge) + " is forbidden";
  if (contains(known.sheet, edge) || contains(known.sheet, reverse))
    return text_of(edge) + " is in the sheet already";
  return {};
}

/// Rim edges once and in the loop's direction, edges inside once in each, and so those that the
/// loop runs along both ways.
std::string edge_defect(const HoleProblem& problem, std::span<const Triangle> rim_faces,
                        const PatchCorners& corners, const std::vector<Edge>& rim) {
  const auto given = static_cast<std::uint32_t>(problem.positions.size());
  const GivenEdges known{rim, sheet_edges_along(problem, rim_faces)};
  for (std::uint32_t v = 0; v < corners.vertices(); ++v) {
    const std::span<const PatchCorners::Corner> at = corners.at(v);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const Edge edge = {v, at[i].next};
      if (i > 0 && at[i - 1].next == at[i].next)
        return text_of(edge) + " is used twice in one direction";
      const bool is_inside = corners.has({edge[1], edge[0]});
      if (v < given && edge[1] < given) {
        std::string defect = given_edge_defect(problem, known, edge, is_inside);
        if (!defect.empty()) return defect;
      } else if (!is_inside) {
        return text_of(edge) + " is a boundary that is not the loop's";
      }
    }
  }
  for (const Edge& edge : rim) {
    // What the loop runs along both ways is no boundary: it may have been cut.
    if (contains(rim, {edge[1], edge[0]})) continue;
    if (!corners.has(edge)) return "rim " + text_of(edge) + " stays open";
  }
  return "";
}

struct Fans {
  std::size_t open = 0;
  std::size_t closed = 0;
};

/// Counts the fans of vertices whose edges are sound: every corner has at most one to its left.
class FanCounter {
 public:
  Fans count(std::span<const PatchCorners::Corner> corners) {
    has_right_.assign(corners.size(), 0);
    seen_.assign(corners.size(), 0);
    for (const PatchCorners::Corner& corner : corners)
      if (const auto* left = PatchCorners::find(corners, corner.previous))
        has_right_[left - corners.data()] = 1;
    Fans fans;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (has_right_[i] != 0) continue;
      ++fans.open;
      follow(corners, i);
    }
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (seen_[i] != 0) continue;
      ++fans.closed;
      follow(corners, i);
    }
    return fans;
  }

 private:
  void follow(std::span<const PatchCorners::Corner> corners, std::size_t i) {
    for (const auto* c = &corners[i]; c != nullptr && seen_[c - corners.data()] == 0;
         c = PatchCorners::find(corners, c->previous))
      seen_[c - corners.data()] = 1;
  }

  std::vector<char> has_right_, seen_;  // per corner
};

/// New vertices have one closed fan. Vertices of the rim have open ones, but for those all of
/// whose edges in the loop are inside (the end of a slit), which have one closed one.
std::string fan_defect(const HoleProblem& problem, const PatchCorners& corners,
                       const std::vector<Edge>& rim) {
  std::vector<char> open(problem.positions.size(), 0);
  for (const Edge& edge : rim) {
    if (!contains(rim, {edge[1], edge[0]})) open[edge[0]] = open[edge[1]] = 1;
  }
  FanCounter counter;
  for (std::uint32_t vertex = 0; vertex < corners.vertices(); ++vertex) {
    if (corners.at(vertex).empty()) continue;
    const Fans fans = counter.count(corners.at(vertex));
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
  return patch_defect(problem, problem.sheet, patch);
}

std::string patch_defect(const HoleProblem& problem, std::span<const Triangle> rim_faces,
                         const HolePatch& patch) {
  if (patch.method == FillMethod::kNone) {
    const bool empty = patch.triangles.empty() && patch.positions.empty();
    return empty ? "" : "triangles of a hole that stays open";
  }
  if (std::string defect = array_defect(problem, patch); !defect.empty()) return defect;
  if (std::string defect = index_defect(problem, patch); !defect.empty()) return defect;
  const std::vector<Edge> rim = edges_of_loop(problem.loop);
  const PatchCorners corners(patch.triangles, problem.positions.size() + patch.positions.size());
  if (std::string defect = edge_defect(problem, rim_faces, corners, rim); !defect.empty())
    return defect;
  if (std::string defect = fan_defect(problem, corners, rim); !defect.empty()) return defect;
  return piece_defect(problem, patch);
}

}  // namespace orbweave
