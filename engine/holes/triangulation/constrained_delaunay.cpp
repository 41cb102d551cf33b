#include "engine/holes/triangulation/constrained_delaunay.h"

#include <algorithm>
#include <utility>

#include "engine/holes/triangulation/insertion_order.h"

namespace orbweave {

ConstrainedDelaunay::ConstrainedDelaunay(std::span<const PlanePoint> points, std::uint32_t corners)
    : points_(points.begin(), points.end()), corners_(corners), site_(corners, kNone32) {
  const auto n = static_cast<std::uint32_t>(points.size());
  constexpr std::int64_t kFrame = 2 * kPlaneExtent;
  points_.insert(points_.end(),
                 {{-kFrame, -kFrame}, {kFrame, -kFrame}, {kFrame, kFrame}, {-kFrame, kFrame}});
  mesh_.from.assign(points_.size(), kNone32);
  mesh_.origin.reserve(6 * points_.size());
  mesh_.twin.reserve(6 * points_.size());
  corner_.reserve(6 * points_.size());
  side_.reserve(2 * points_.size());
  const std::uint32_t h = mesh_.add(n, n + 1, n + 2);
  const std::uint32_t g = mesh_.add(n + 2, n + 3, n);
  side_.assign(2, Side::kUnknown);
  corner_.assign(6, kNone32);
  mesh_.link(h + 2, g + 2);
}

// ---- Points --------------------------------------------------------------------------------

// The edges of a triangle are tried from a random one on: a walk in a triangulation that is not
// Delaunay could otherwise run in circles (Devillers, Pion, Teillaud: Walking in a Triangulation,
// 2001).
ConstrainedDelaunay::Location ConstrainedDelaunay::locate(PlanePoint p) {
  std::uint32_t t = last_ / 3;
  for (std::uint32_t entered = kNone32;;) {
    random_ = random_ * 6364136223846793005ULL + 1442695040888963407ULL;
    std::uint32_t h = 3 * t + static_cast<std::uint32_t>((random_ >> 33) % 3);
    std::uint32_t left = kNone32;
    std::uint32_t on[2] = {kNone32, kNone32};
    for (int k = 0; k < 3 && left == kNone32; ++k, h = HalfEdges::next(h)) {
      if (h == entered) continue;
      const std::int64_t turn = orientation(at(mesh_.origin[h]), at(mesh_.target(h)), p);
      if (turn < 0) left = h;
      if (turn == 0) (on[0] == kNone32 ? on[0] : on[1]) = h;
    }
    if (left == kNone32) {
      last_ = 3 * t;
      if (on[1] != kNone32) {
        return {HalfEdges::next(on[0]) == on[1] ? on[1] : on[0], Location::At::kVertex};
      }
      if (on[0] != kNone32) return {on[0], Location::At::kEdge};
      return {3 * t, Location::At::kTriangle};
    }
    entered = mesh_.twin[left];
    t = entered / 3;
  }
}

void ConstrainedDelaunay::insert(std::uint32_t vertex, const Location& where) {
  if (where.at == Location::At::kEdge) {
    split_edge(where.h, vertex);
  } else {
    split_triangle(where.h, vertex);
  }
  last_ = mesh_.from[vertex];
  legalize();
}

void ConstrainedDelaunay::split_triangle(std::uint32_t h, std::uint32_t vertex) {
  const std::uint32_t second = mesh_.split_triangle(h, vertex);
  side_.insert(side_.end(), 2, side_[h / 3]);
  corner_.insert(corner_.end(), 6, kNone32);
  corner_[second] = std::exchange(corner_[HalfEdges::next(h)], kNone32);
  corner_[second + 3] = std::exchange(corner_[HalfEdges::prev(h)], kNone32);
  suspect_.insert(suspect_.end(), {h, second, second + 3});
}

void ConstrainedDelaunay::split_edge(std::uint32_t h, std::uint32_t vertex) {
  const std::uint32_t g = mesh_.twin[h];
  const std::uint32_t upper = mesh_.split_edge(h, vertex);
  side_.insert(side_.end(), {side_[h / 3], side_[g / 3]});
  corner_.insert(corner_.end(), 6, kNone32);
  corner_[upper + 1] = std::exchange(corner_[HalfEdges::next(h)], kNone32);
  corner_[upper + 5] = std::exchange(corner_[HalfEdges::prev(g)], kNone32);
  suspect_.insert(suspect_.end(), {HalfEdges::prev(h), upper + 1, HalfEdges::next(g), upper + 5});
}

void ConstrainedDelaunay::flip(std::uint32_t h) {
  const std::uint32_t g = mesh_.twin[h];
  corner_[h] = std::exchange(corner_[HalfEdges::prev(g)], kNone32);
  corner_[g] = std::exchange(corner_[HalfEdges::prev(h)], kNone32);
  mesh_.flip(h);
}

void ConstrainedDelaunay::legalize() {
  while (!suspect_.empty()) {
    const std::uint32_t h = suspect_.back();
    suspect_.pop_back();
    const std::uint32_t g = mesh_.twin[h];
    if (g == kNone32 || is_constrained(h)) continue;
    const std::uint32_t across = mesh_.apex(g);
    if (side_of_circle(at(mesh_.origin[h]), at(mesh_.target(h)), at(mesh_.apex(h)), at(across)) <=
        0) {
      continue;
    }
    flip(h);
    suspect_.push_back(h);
    suspect_.push_back(HalfEdges::next(g));
  }
}

void ConstrainedDelaunay::insert_interior() {
  const auto last = static_cast<std::uint32_t>(points_.size() - 4);
  if (last == corners_) return;
  last_ = mesh_.from[site_[0]];
  for (const std::uint32_t vertex : insertion_order(points_, corners_, last)) {
    const Location where = locate(at(vertex));
    if (where.at == Location::At::kVertex || !is_inside(where.h)) continue;
    if (where.at == Location::At::kEdge && is_constrained(where.h)) continue;
    insert(vertex, where);
  }
}

// ---- The polygon ---------------------------------------------------------------------------

bool ConstrainedDelaunay::insert_polygon() {
  for (const std::uint32_t corner : insertion_order(points_, 0, corners_)) {
    const Location where = locate(at(corner));
    if (where.at == Location::At::kVertex) {
      site_[corner] = mesh_.origin[where.h];
    } else {
      insert(corner, where);
      site_[corner] = corner;
    }
  }
  for (std::uint32_t corner = 0; corner < corners_; ++corner) {
    if (!constrain(corner)) return false;
  }
  return find_sides();
}

bool ConstrainedDelaunay::tag(std::uint32_t h, std::uint32_t corner) {
  if (corner_[h] != kNone32) return false;  // an edge twice in the same direction
  corner_[h] = corner;
  return true;
}

/// What lies under a new edge from a to b: triangles, and the vertices beside it.
struct ConstrainedDelaunay::Crossed {
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> left, right;  ///< from a to b
};

bool ConstrainedDelaunay::constrain(std::uint32_t corner) {
  const std::uint32_t a = site_[corner];
  const std::uint32_t b = site_[corner + 1 == corners_ ? 0 : corner + 1];
  if (a == b) return false;
  bool exists = false;
  const std::uint32_t h = first_crossed(a, b, exists);
  if (h == kNone32) return false;
  if (exists) return tag(h, corner);
  Crossed crossed;
  if (!collect_crossed(a, b, h, crossed)) return false;
  std::vector<CornerTriangle> triangles;
  fill_side(a, b, crossed.left, triangles);
  std::reverse(crossed.right.begin(), crossed.right.end());
  fill_side(b, a, crossed.right, triangles);
  replace(crossed, triangles);
  bool found = false;
  return tag(first_crossed(a, b, found), corner);
}

// The half-edge from a to b (`exists`), or the one opposite a that the way to b crosses; kNone32
// when a vertex lies on the way.
std::uint32_t ConstrainedDelaunay::first_crossed(std::uint32_t a, std::uint32_t b,
                                                 bool& exists) const {
  const std::uint32_t start = mesh_.from[a];
  std::uint32_t blocked = kNone32;
  std::uint32_t crossed = kNone32;
  std::uint32_t h = start;
  do {
    const std::uint32_t u = mesh_.target(h);
    exists = u == b;
    if (exists) return h;
    const std::int64_t right = turn(a, u, b);
    const bool ahead =
        (at(u).x - at(a).x) * (at(b).x - at(a).x) + (at(u).y - at(a).y) * (at(b).y - at(a).y) > 0;
    if (right == 0 && ahead) blocked = u;
    if (right > 0 && turn(a, mesh_.apex(h), b) < 0) crossed = HalfEdges::next(h);
    h = mesh_.left_of(h);
  } while (h != start);
  return blocked == kNone32 ? crossed : kNone32;
}

bool ConstrainedDelaunay::collect_crossed(std::uint32_t a, std::uint32_t b, std::uint32_t h,
                                          Crossed& crossed) const {
  crossed.triangles.push_back(h / 3);
  crossed.right.push_back(mesh_.origin[h]);
  crossed.left.push_back(mesh_.target(h));
  while (true) {
    if (is_constrained(h)) return false;
    const std::uint32_t g = mesh_.twin[h];
    crossed.triangles.push_back(g / 3);
    const std::uint32_t apex = mesh_.apex(g);
    if (apex == b) return true;
    const std::int64_t side = turn(a, b, apex);
    if (side == 0) return false;
    (side > 0 ? crossed.left : crossed.right).push_back(apex);
    h = side > 0 ? HalfEdges::next(g) : HalfEdges::prev(g);
  }
}

// Triangulates the polygon to the left of the edge a-b, whose other vertices are the chain from a
// to b: the triangle at an edge is the one whose circle holds no vertex of its chain (Anglada,
// section 4). The chain may pass a vertex twice.
void ConstrainedDelaunay::fill_side(std::uint32_t a, std::uint32_t b,
                                    std::span<const std::uint32_t> chain,
                                    std::vector<CornerTriangle>& out) const {
  struct Piece {
    std::uint32_t a, b;
    std::span<const std::uint32_t> chain;
  };
  std::vector<Piece> pieces{{a, b, chain}};
  while (!pieces.empty()) {
    const Piece piece = pieces.back();
    pieces.pop_back();
    if (piece.chain.empty()) continue;
    std::size_t best = 0;
    for (std::size_t i = 1; i < piece.chain.size(); ++i) {
      if (side_of_circle(at(piece.a), at(piece.b), at(piece.chain[best]), at(piece.chain[i])) > 0) {
        best = i;
      }
    }
    const std::uint32_t c = piece.chain[best];
    out.push_back({piece.a, piece.b, c});
    pieces.push_back({piece.a, c, piece.chain.first(best)});
    pieces.push_back({c, piece.b, piece.chain.subspan(best + 1)});
  }
}

// Puts triangles in the place of the crossed ones, which cover the same ground.
void ConstrainedDelaunay::replace(const Crossed& crossed,
                                  std::span<const CornerTriangle> triangles) {
  struct Edge {
    std::uint32_t a, b, twin, corner;
  };
  const auto before = [](const Edge& p, const Edge& q) {
    return p.a != q.a ? p.a < q.a : p.b < q.b;
  };
  const auto find = [&](const std::vector<Edge>& edges, std::uint32_t a, std::uint32_t b) {
    const auto found = std::lower_bound(edges.begin(), edges.end(), Edge{a, b, 0, 0}, before);
    return found != edges.end() && found->a == a && found->b == b ? &*found : nullptr;
  };
  std::vector<Edge> old_edges;
  for (const std::uint32_t t : crossed.triangles) {
    for (std::uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
      old_edges.push_back({mesh_.origin[h], mesh_.target(h), mesh_.twin[h], corner_[h]});
    }
  }
  std::sort(old_edges.begin(), old_edges.end(), before);
  std::vector<Edge> new_edges;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto [a, b, c] = triangles[i];
    mesh_.set(crossed.triangles[i], a, b, c);
    const std::uint32_t h = 3 * crossed.triangles[i];
    new_edges.insert(new_edges.end(), {{a, b, h, 0}, {b, c, h + 1, 0}, {c, a, h + 2, 0}});
  }
  std::sort(new_edges.begin(), new_edges.end(), before);
  for (const Edge& edge : new_edges) {
    const Edge* kept = find(old_edges, edge.a, edge.b);
    const Edge* twin = find(new_edges, edge.b, edge.a);
    corner_[edge.twin] = kept != nullptr ? kept->corner : kNone32;
    mesh_.link(edge.twin, twin != nullptr ? twin->twin : kept->twin);
  }
}

// ---- Inside and outside --------------------------------------------------------------------

bool ConstrainedDelaunay::find_sides() {
  std::vector<std::uint32_t> reached;
  for (std::uint32_t h = 0; h < mesh_.size(); ++h) {
    const std::uint32_t g = mesh_.twin[h];
    if (g == kNone32 && !spread(h, Side::kOutside, reached)) return false;
    if (corner_[h] == kNone32) continue;
    if (!spread(h, Side::kInside, reached)) return false;
    if (corner_[g] == kNone32 && !spread(g, Side::kOutside, reached)) return false;
  }
  return true;
}

// False where the region of h is known to be on the other side.
bool ConstrainedDelaunay::spread(std::uint32_t h, Side side, std::vector<std::uint32_t>& reached) {
  if (side_[h / 3] != Side::kUnknown) return side_[h / 3] == side;
  side_[h / 3] = side;
  reached.assign(1, h / 3);
  while (!reached.empty()) {
    const std::uint32_t t = reached.back();
    reached.pop_back();
    for (std::uint32_t g = 3 * t; g < 3 * t + 3; ++g) {
      if (mesh_.twin[g] == kNone32 || is_constrained(g)) continue;
      Side& across = side_[mesh_.twin[g] / 3];
      if (across != Side::kUnknown) continue;  // a conflict is seen where it was seeded
      across = side;
      reached.push_back(mesh_.twin[g] / 3);
    }
  }
  return true;
}

// The triangles of a corner lie, counter-clockwise, between its edge to the next corner and its
// edge to the corner before.
bool ConstrainedDelaunay::separate_corners() {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> owned;  // half-edge, corner
  for (std::uint32_t first = 0; first < mesh_.size(); ++first) {
    const std::uint32_t corner = corner_[first];
    if (corner == kNone32) continue;
    std::uint32_t h = first;
    std::uint32_t closing = kNone32;
    do {
      owned.emplace_back(h, corner);
      const std::uint32_t last = HalfEdges::prev(h);
      closing = corner_[last];
      h = mesh_.twin[last];
    } while (closing == kNone32 && h != first);
    if (closing != (corner == 0 ? corners_ : corner) - 1) return false;
  }
  for (const auto& [h, corner] : owned) mesh_.origin[h] = corner;
  return true;
}

// ---- Chords --------------------------------------------------------------------------------

bool ConstrainedDelaunay::chord_can_flip(std::uint32_t h,
                                         const ForbiddenChord& is_forbidden) const {
  const std::uint32_t a = mesh_.origin[h];
  const std::uint32_t b = mesh_.target(h);
  const std::uint32_t c = mesh_.apex(h);
  const std::uint32_t d = mesh_.apex(mesh_.twin[h]);
  return turn(c, a, d) > 0 && turn(d, b, c) > 0 && !is_bad_chord(c, d, is_forbidden);
}

// Every flip removes a forbidden chord and makes none, but may make room for another flip.
void ConstrainedDelaunay::avoid_chords(const ForbiddenChord& is_forbidden) {
  for (bool flipped = true; flipped;) {
    flipped = false;
    for (std::uint32_t h = 0; h < mesh_.size(); ++h) {
      if (!is_inside(h) || mesh_.twin[h] < h || is_constrained(h)) continue;
      if (!is_bad_chord(mesh_.origin[h], mesh_.target(h), is_forbidden)) continue;
      if (!chord_can_flip(h, is_forbidden)) continue;
      flip(h);
      flipped = true;
    }
  }
}

std::vector<CornerTriangle> ConstrainedDelaunay::inside() const {
  std::vector<CornerTriangle> triangles;
  for (std::uint32_t h = 0; h < mesh_.size(); h += 3) {
    if (!is_inside(h)) continue;
    triangles.push_back({mesh_.origin[h], mesh_.origin[h + 1], mesh_.origin[h + 2]});
  }
  return triangles;
}

}  // namespace orbweave
