#include "engine/holes/patch/sound_part.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "engine/geometry/disjoint_sets.h"
#include "engine/holes/patch/loop_edges.h"

namespace orbweave {
namespace {

using Edge = std::array<std::uint32_t, 2>;

/// A triangle's corner at a vertex: edges to `next` and from `previous`.
struct PatchCorner {
  std::uint32_t vertex = 0;
  std::uint32_t next = 0;
  std::uint32_t previous = 0;
  std::uint32_t triangle = 0;
  friend auto operator<=>(const PatchCorner&, const PatchCorner&) = default;
};

/// Whether the loop runs along an edge in both directions: a bridge, which only a whole patch
/// holds.
bool runs_both_ways(const std::vector<std::uint32_t>& loop) {
  const std::vector<Edge> edges = edges_of_loop(loop);
  return std::any_of(edges.begin(), edges.end(), [&](const Edge& edge) {
    return std::binary_search(edges.begin(), edges.end(), Edge{edge[1], edge[0]});
  });
}

/// Takes triangles out of a patch until what is left is sound.
class Trimming {
 public:
  Trimming(const HoleProblem& problem, const HolePatch& patch)
      : triangles_(patch.triangles),
        given_(static_cast<std::uint32_t>(problem.positions.size())),
        rim_(edges_of_loop(problem.loop)),
        is_kept_(patch.triangles.size(), 1) {
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      for (int k = 0; k < 3; ++k)
        corners_.push_back(
            {triangles_[t][k], triangles_[t][(k + 1) % 3], triangles_[t][(k + 2) % 3], t});
    std::sort(corners_.begin(), corners_.end());
  }

  const std::vector<std::uint8_t>& is_kept() const { return is_kept_; }
  std::size_t kept() const {
    return static_cast<std::size_t>(std::count(is_kept_.begin(), is_kept_.end(), 1));
  }

  /// Of two triangles of the patch that cross, the one that crosses more goes, else the later one.
  void drop_contacts(const std::vector<Contact>& contacts) {
    std::vector<Contact> own;
    for (const Contact& contact : contacts) {
      if (contact[1] >= triangles_.size())
        is_kept_[contact[0]] = 0;
      else
        own.push_back(contact);
    }
    std::vector<std::uint32_t> met(triangles_.size(), 0);
    const auto both_left = [&](const Contact& c) { return is_kept_[c[0]] && is_kept_[c[1]]; };
    for (const Contact& contact : own) {
      if (!both_left(contact)) continue;
      ++met[contact[0]];
      ++met[contact[1]];
    }
    const auto more_met = [&](std::uint32_t a, std::uint32_t b) {
      return met[a] != met[b] ? met[a] > met[b] : a > b;
    };
    for (const Contact& contact : own) {
      if (!both_left(contact)) continue;
      is_kept_[more_met(contact[0], contact[1]) ? contact[0] : contact[1]] = 0;
    }
  }

  /// Drops what hangs on by a vertex alone, until nothing does.
  void drop_loose_ends() {
    while (drop_loose_fans() || drop_loose_pieces()) {
    }
  }

  /// Edges of the triangles that are left which no other one of them and no face at the rim has,
  /// and edges of the rim that stay open.
  std::uint32_t count_open_edges() const {
    std::vector<Edge> edges;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (!is_kept_[t]) continue;
      for (int k = 0; k < 3; ++k) edges.push_back({triangles_[t][k], triangles_[t][(k + 1) % 3]});
    }
    std::sort(edges.begin(), edges.end());
    std::uint32_t open = 0;
    for (const Edge& edge : edges)
      open += !std::binary_search(edges.begin(), edges.end(), Edge{edge[1], edge[0]}) &&
                      !is_rim(edge[0], edge[1])
                  ? 1
                  : 0;
    for (const Edge& edge : rim_)
      open += !std::binary_search(edges.begin(), edges.end(), edge) ? 1 : 0;
    return open;
  }

 private:
  bool is_rim(std::uint32_t tail, std::uint32_t head) const {
    return std::binary_search(rim_.begin(), rim_.end(), Edge{tail, head});
  }

  /// The fans of kept corners [begin, end), all of one vertex: per corner the smallest of its fan.
  std::vector<std::uint32_t> fans_of(std::size_t begin, std::size_t end) const {
    DisjointSets fans(end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_kept_[corners_[i].triangle]) continue;
      const auto at = std::lower_bound(
          corners_.begin() + static_cast<std::ptrdiff_t>(begin),
          corners_.begin() + static_cast<std::ptrdiff_t>(end), corners_[i].previous,
          [](const PatchCorner& corner, std::uint32_t next) { return corner.next < next; });
      const auto other = static_cast<std::size_t>(at - corners_.begin());
      if (other < end && at->next == corners_[i].previous && is_kept_[at->triangle])
        fans.unite(static_cast<std::uint32_t>(i - begin),
                   static_cast<std::uint32_t>(other - begin));
    }
    std::vector<std::uint32_t> label(end - begin);
    for (std::uint32_t i = 0; i < label.size(); ++i) label[i] = fans.find(i);
    return label;
  }

  /// At a vertex of the rim a fan stays that has an edge of the rim there, at a new one the
  /// largest.
  bool drop_fans_at(std::size_t begin, std::size_t end) {
    const std::vector<std::uint32_t> label = fans_of(begin, end);
    const std::uint32_t vertex = corners_[begin].vertex;
    std::vector<std::uint32_t> size(label.size(), 0);
    std::vector<std::uint8_t> stays(label.size(), 0);
    for (std::size_t i = begin; i < end; ++i) {
      const PatchCorner& corner = corners_[i];
      if (!is_kept_[corner.triangle]) continue;
      ++size[label[i - begin]];
      if (vertex < given_ && (is_rim(vertex, corner.next) || is_rim(corner.previous, vertex)))
        stays[label[i - begin]] = 1;
    }
    if (vertex >= given_)
      stays[static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin())] =
          1;
    bool any = false;
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_kept_[corners_[i].triangle] || stays[label[i - begin]]) continue;
      is_kept_[corners_[i].triangle] = 0;
      any = true;
    }
    return any;
  }

  bool drop_loose_fans() {
    bool any = false;
    for (std::size_t begin = 0, end = 0; begin < corners_.size(); begin = end) {
      while (end < corners_.size() && corners_[end].vertex == corners_[begin].vertex) ++end;
      any = drop_fans_at(begin, end) || any;
    }
    return any;
  }

  /// Drops pieces, joined over edges, that have no edge of the rim.
  bool drop_loose_pieces() {
    DisjointSets pieces(triangles_.size());
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const PatchCorner& corner = corners_[i];
      if (!is_kept_[corner.triangle]) continue;
      // The triangle on the other side of the edge from this vertex to the next.
      const auto at = std::lower_bound(corners_.begin(), corners_.end(),
                                       PatchCorner{corner.next, corner.vertex, 0, 0});
      if (at != corners_.end() && at->vertex == corner.next && at->next == corner.vertex &&
          is_kept_[at->triangle])
        pieces.unite(corner.triangle, at->triangle);
    }
    std::vector<std::uint8_t> stays(triangles_.size(), 0);
    for (const PatchCorner& corner : corners_)
      if (is_kept_[corner.triangle] && is_rim(corner.vertex, corner.next))
        stays[pieces.find(corner.triangle)] = 1;
    bool any = false;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (!is_kept_[t] || stays[pieces.find(t)]) continue;
      is_kept_[t] = 0;
      any = true;
    }
    return any;
  }

  const std::vector<Triangle>& triangles_;
  const std::uint32_t given_;
  const std::vector<Edge> rim_;        // sorted
  std::vector<PatchCorner> corners_;   // sorted
  std::vector<std::uint8_t> is_kept_;  // per triangle
};

/// The patch with these triangles and the new vertices that they use.
void keep_triangles(const std::vector<std::uint8_t>& is_kept, std::uint32_t given,
                    std::uint32_t channels, HolePatch& patch) {
  std::size_t kept = 0;
  std::vector<std::uint32_t> number(patch.positions.size(), 0);
  for (std::size_t t = 0; t < is_kept.size(); ++t) {
    if (!is_kept[t]) continue;
    patch.triangles[kept++] = patch.triangles[t];
    for (const std::uint32_t v : patch.triangles[t])
      if (v >= given) number[v - given] = 1;
  }
  patch.triangles.resize(kept);
  std::uint32_t used = 0;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] == 0) continue;
    patch.positions[used] = patch.positions[v];
    patch.normals[used] = patch.normals[v];
    for (std::size_t c = 0; c < channels; ++c)
      patch.values[used * channels + c] = patch.values[v * channels + c];
    number[v] = given + used++;
  }
  patch.positions.resize(used);
  patch.normals.resize(used);
  patch.values.resize(std::size_t{used} * channels);
  for (Triangle& t : patch.triangles)
    for (std::uint32_t& v : t)
      if (v >= given) v = number[v - given];
}

}  // namespace

HolePatch sound_part(const HoleProblem& problem, HolePatch patch,
                     const std::vector<Contact>& contacts) {
  if (contacts.empty()) return patch;
  if (runs_both_ways(problem.loop)) return {};
  Trimming trimming(problem, patch);
  trimming.drop_contacts(contacts);
  trimming.drop_loose_ends();
  if (2 * trimming.kept() < patch.triangles.size()) return {};
  patch.open_edges = trimming.count_open_edges();
  keep_triangles(trimming.is_kept(), static_cast<std::uint32_t>(problem.positions.size()),
                 problem.channels, patch);
  return patch;
}

}  // namespace orbweave
