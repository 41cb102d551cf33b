// Short edges of a patch; whether it is a disc.
#include <algorithm>
#include <tuple>
#include <utility>

#include "engine/holes/patch/patch_mesh.h"
#include "engine/holes/triangulation/loop_chords.h"

namespace orbweave {

// The vertex a of h from a to b goes, and b takes its place.
bool PatchMesh::can_collapse(std::uint32_t h) const {
  constexpr double kMostTurn = 0.2;  // least cosine between a face before and after
  const std::uint32_t a = mesh_.origin[h];
  const std::uint32_t b = mesh_.target(h);
  const std::uint32_t c = mesh_.apex(h);
  if (a < corners_ || mesh_.twin[h] == kNone32) return false;
  const std::uint32_t d = mesh_.apex(mesh_.twin[h]);
  for (std::uint32_t e = mesh_.left_of(h); e != h; e = mesh_.left_of(e)) {
    const std::uint32_t x = mesh_.target(e);
    if (x != c && x != d && !may_join(b, x)) return false;
    if (x == d) continue;  // the triangle to the left of a-d holds b
    const Facet before = facet(at(a), at(x), at(mesh_.apex(e)));
    const Facet after = facet(at(b), at(x), at(mesh_.apex(e)));
    if (after.normal == Vec3{} || dot(before.normal, after.normal) < kMostTurn) return false;
  }
  return true;
}

void PatchMesh::collapse(std::uint32_t h) {
  const std::uint32_t g = mesh_.twin[h];
  const std::uint32_t a = mesh_.origin[h];
  const std::uint32_t b = mesh_.target(h);
  const std::uint32_t c = mesh_.apex(h);
  const std::uint32_t d = mesh_.apex(g);
  for (std::uint32_t e = mesh_.left_of(h); e != h; e = mesh_.left_of(e)) mesh_.origin[e] = b;
  const std::uint32_t to_c = mesh_.twin[HalfEdges::prev(h)];
  const std::uint32_t from_d = mesh_.twin[HalfEdges::next(g)];
  mesh_.link(mesh_.twin[HalfEdges::next(h)], to_c);
  mesh_.link(mesh_.twin[HalfEdges::prev(g)], from_d);
  mesh_.from[a] = kNone32;
  mesh_.from[b] = to_c;
  mesh_.from[c] = HalfEdges::next(to_c);
  mesh_.from[d] = from_d;
  for (const std::uint32_t first : {h - h % 3, g - g % 3}) {
    for (std::uint32_t e = first; e < first + 3; ++e) {
      mesh_.origin[e] = mesh_.twin[e] = kNone32;
    }
  }
}

/// Points from `first` on may go.
std::uint32_t PatchMesh::collapse_pass(double shortest, std::uint32_t first) {
  std::vector<std::tuple<double, std::uint32_t, std::uint32_t>> edges;
  for (std::uint32_t h = 0; h < mesh_.size(); ++h) {
    if (mesh_.twin[h] == kNone32 || mesh_.twin[h] < h) continue;
    const auto [a, b] = vertex_pair(mesh_.origin[h], mesh_.target(h));
    const double length = squared_norm(at(b) - at(a));
    if (length < shortest * shortest) edges.emplace_back(length, a, b);
  }
  std::sort(edges.begin(), edges.end());
  std::uint32_t count = 0;
  for (const auto& [length, a, b] : edges) {
    for (const auto& [gone, kept] : {std::pair(b, a), std::pair(a, b)}) {
      if (gone < first) continue;
      const std::uint32_t h = find_edge(gone, kept);
      if (h == kNone32 || !can_collapse(h)) continue;
      collapse(h);
      ++count;
      break;
    }
  }
  return count;
}

std::uint32_t PatchMesh::collapse_down_to(double shortest, std::uint32_t first) {
  std::uint32_t count = 0;
  for (std::uint32_t more = 1; more > 0; count += more) {
    more = collapse_pass(shortest, first);
    if (more > 0) mesh_.drop_removed();
  }
  return count;
}

std::uint32_t PatchMesh::collapse_short_edges(double shortest) {
  return collapse_down_to(shortest, corners_);
}

// ---- Soundness -----------------------------------------------------------------------------

std::string PatchMesh::defect() const {
  if (mesh_.size() == 0) return "no triangles";
  std::vector<std::uint32_t> in_fans(size(), 0);
  std::vector<std::uint32_t> used(size(), 0);
  std::uint32_t rim_edges = 0;
  for (std::uint32_t h = 0; h < mesh_.size(); ++h) {
    const std::uint32_t a = mesh_.origin[h];
    const std::uint32_t b = mesh_.target(h);
    const std::uint32_t g = mesh_.twin[h];
    if (a == b) return "a triangle without area";
    ++used[a];
    if (g != kNone32) {
      const bool linked = mesh_.twin[g] == h && mesh_.origin[g] == b && mesh_.target(g) == a;
      if (!linked) return "an edge whose triangles do not agree";
      continue;
    }
    if (a >= corners_ || b != (a + 1) % corners_) return "a boundary that is not the loop";
    ++rim_edges;
  }
  if (rim_edges != corners_) return "a boundary that is not the whole loop";
  for (std::uint32_t v = 0; v < size(); ++v) {
    if (mesh_.from[v] == kNone32) {
      if (used[v] > 0 || v < corners_) return "a vertex without its triangles";
      continue;
    }
    if (mesh_.origin[mesh_.from[v]] != v) return "a vertex with another's triangle";
    const std::uint32_t first = mesh_.first_of_fan(mesh_.from[v]);
    std::uint32_t h = first;
    do {
      ++in_fans[v];
      h = mesh_.left_of(h);
    } while (h != kNone32 && h != first);
    if ((h == kNone32) != (v < corners_)) return "a fan that is open inside or closed at the rim";
    if (in_fans[v] != used[v]) return "a vertex of several fans";
  }
  // One boundary: a disc has one vertex more than edges minus triangles; further pieces, which
  // have no boundary, and handles would change that.
  const auto vertices = size() - std::count(mesh_.from.begin(), mesh_.from.end(), kNone32);
  const auto triangle_count = static_cast<std::int64_t>(mesh_.size() / 3);
  const std::int64_t edges = (3 * triangle_count + rim_edges) / 2;
  return vertices - edges + triangle_count == 1 ? "" : "not one disc";
}

}  // namespace orbweave
