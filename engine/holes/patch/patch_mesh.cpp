#include "engine/holes/patch/patch_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

#include "engine/geometry/vertex_groups.h"
#include "engine/holes/triangulation/loop_chords.h"

namespace orbweave {

PatchMesh::PatchMesh(std::vector<Vec3> positions, std::span<const std::uint32_t> vertices,
                     std::span<const CornerTriangle> triangles,
                     std::span<const std::array<std::uint32_t, 2>> forbidden,
                     std::span<const std::array<std::uint32_t, 2>> apart)
    : positions_(std::move(positions)),
      corners_(static_cast<std::uint32_t>(vertices.size())),
      vertices_(vertices.begin(), vertices.end()),
      forbidden_(forbidden.begin(), forbidden.end()),
      apart_(apart.begin(), apart.end()) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> visits;
  for (std::uint32_t i = 0; i < corners_; ++i) visits[vertices_[i]].push_back(i);
  first_visit_.resize(corners_);
  next_visit_.resize(corners_);
  for (const auto& [vertex, at_corners] : visits) {
    for (std::size_t i = 0; i < at_corners.size(); ++i) {
      first_visit_[at_corners[i]] = at_corners.front();
      next_visit_[at_corners[i]] = at_corners[(i + 1) % at_corners.size()];
    }
  }
  if (!mesh_.assign(triangles, size())) mesh_ = {{}, {}, std::vector(size(), kNone32)};
}

std::vector<CornerTriangle> PatchMesh::triangles() const {
  std::vector<CornerTriangle> triangles;
  triangles.reserve(mesh_.size() / 3);
  for (std::uint32_t h = 0; h < mesh_.size(); h += 3) {
    triangles.push_back({mesh_.origin[h], mesh_.origin[h + 1], mesh_.origin[h + 2]});
  }
  return triangles;
}

std::vector<std::vector<std::uint32_t>> PatchMesh::neighbors() const {
  std::vector<std::vector<std::uint32_t>> neighbors(size());
  for (std::uint32_t h = 0; h < mesh_.size(); ++h) {
    neighbors[mesh_.origin[h]].push_back(mesh_.target(h));
    if (mesh_.twin[h] == kNone32) neighbors[mesh_.target(h)].push_back(mesh_.origin[h]);
  }
  for (auto& list : neighbors) std::sort(list.begin(), list.end());
  return neighbors;
}

// ---- Which edges may be --------------------------------------------------------------------

bool PatchMesh::is_forbidden(std::uint32_t a, std::uint32_t b) const {
  if (a >= corners_ || b >= corners_) return false;
  const VertexPair pair = vertex_pair(vertices_[a], vertices_[b]);
  return std::binary_search(forbidden_.begin(), forbidden_.end(), pair) ||
         share_a_group(apart_, pair[0], pair[1]);
}

std::uint32_t PatchMesh::find_edge(std::uint32_t a, std::uint32_t b) const {
  if (mesh_.from[a] == kNone32) return kNone32;
  const std::uint32_t first = mesh_.first_of_fan(mesh_.from[a]);
  std::uint32_t h = first;
  do {
    if (mesh_.target(h) == b) return h;
    h = mesh_.left_of(h);
  } while (h != kNone32 && h != first);
  return kNone32;
}

/// True when an edge joins the same two mesh vertices.
bool PatchMesh::is_joined(std::uint32_t a, std::uint32_t b) const {
  std::uint32_t corner = a;
  do {
    if (mesh_.from[corner] == kNone32) continue;
    const std::uint32_t first = mesh_.first_of_fan(mesh_.from[corner]);
    std::uint32_t h = first;
    do {
      if (identity(mesh_.target(h)) == identity(b)) return true;
      if (identity(mesh_.apex(h)) == identity(b)) return true;
      h = mesh_.left_of(h);
    } while (h != kNone32 && h != first);
  } while (a < corners_ && (corner = next_visit_[corner]) != a);
  return false;
}

bool PatchMesh::may_join(std::uint32_t a, std::uint32_t b) const {
  return identity(a) != identity(b) && !is_forbidden(a, b) && !is_joined(a, b);
}

// ---- Splits --------------------------------------------------------------------------------

std::uint32_t PatchMesh::split(std::uint32_t h, Vec3 position) {
  positions_.push_back(position);
  mesh_.from.push_back(kNone32);
  const std::uint32_t g = mesh_.twin[h];
  const std::uint32_t upper = mesh_.split_edge(h, size() - 1);
  is_changed_.resize(mesh_.size() / 3, 1);
  is_changed_[h / 3] = is_changed_[g / 3] = 1;
  return upper;
}

bool PatchMesh::is_long(std::uint32_t h, double longest) const {
  const std::uint32_t g = mesh_.twin[h];
  const double length = squared_norm(at(mesh_.target(h)) - at(mesh_.origin[h]));
  if (g == kNone32 || !(length > longest * longest)) return false;
  // The new vertex must not be joined to a vertex twice.
  if (identity(mesh_.origin[h]) == identity(mesh_.origin[g])) return false;
  if (identity(mesh_.apex(h)) == identity(mesh_.apex(g))) return false;
  // Nor lie on a vertex: where a flat triangle's apex is the midpoint already, this never ended.
  const Vec3 middle = 0.5 * (at(mesh_.origin[h]) + at(mesh_.target(h)));
  constexpr double kOnApex = 1e-4;  // of the squared length
  for (const std::uint32_t apex : {mesh_.apex(h), mesh_.apex(g)}) {
    if (squared_norm(at(apex) - middle) < kOnApex * length) return false;
  }
  // Nor close to a longer edge, which is one that stays (of the rim, or beside it): points would
  // gather along it without end. Its distance is half the height of the triangle.
  constexpr double kClearance = 0.25;
  for (const std::uint32_t e :
       {HalfEdges::next(h), HalfEdges::prev(h), HalfEdges::next(g), HalfEdges::prev(g)}) {
    const Vec3 side = at(mesh_.target(e)) - at(mesh_.origin[e]);
    const Vec3 other = at(mesh_.apex(e)) - at(mesh_.origin[e]);
    const double clearance = 2.0 * kClearance * longest * norm(side);
    if (squared_norm(side) > length && norm(cross(side, other)) < clearance) return false;
  }
  return true;
}

std::uint32_t PatchMesh::split_pass(double longest, std::uint32_t max_points) {
  struct Entry {
    double length;
    std::uint32_t a, b;
    bool operator<(const Entry& other) const {
      return std::tie(length, other.a, other.b) < std::tie(other.length, a, b);
    }
  };
  std::priority_queue<Entry> queue;
  const auto push = [&](std::uint32_t h) {
    if (!is_long(h, longest)) return;
    const auto [a, b] = vertex_pair(mesh_.origin[h], mesh_.target(h));
    queue.push({squared_norm(at(b) - at(a)), a, b});
  };
  for (std::uint32_t h = 0; h < mesh_.size(); ++h) {
    if (mesh_.twin[h] != kNone32 && h < mesh_.twin[h]) push(h);
  }
  std::uint32_t count = 0;
  for (; count < max_points && !queue.empty();) {
    const auto [length, a, b] = queue.top();
    queue.pop();
    const std::uint32_t h = find_edge(a, b);
    if (h == kNone32 || !is_long(h, longest)) continue;
    const std::uint32_t upper = split(h, 0.5 * (at(a) + at(b)));
    const std::uint32_t g = mesh_.twin[h];
    for (const std::uint32_t e : {h, upper, HalfEdges::next(h), HalfEdges::prev(g)}) push(e);
    // What lies around may have had to wait for this edge.
    for (const std::uint32_t e : {HalfEdges::prev(h), upper + 1, HalfEdges::next(g), upper + 5}) {
      push(e);
    }
    ++count;
  }
  return count;
}

// Bisecting the slivers of a triangulation without interior points down to short edges would leave
// many times the points that are needed. The limit comes down by steps instead, and at each of them
// the new points that lie close to others go.
std::uint32_t PatchMesh::split_long_edges(double longest, std::uint32_t max_points,
                                          const StopToken* stop) {
  constexpr double kStep = 1.5;
  constexpr double kClose = 0.5;
  constexpr int kRounds = 8;  // flips may make long edges again, fewer each time
  const std::uint32_t before = size();
  double limit = 0.0;  // of the edges that can be split, at most
  for (std::uint32_t h = 0; h < mesh_.size(); ++h) {
    if (mesh_.twin[h] == kNone32) continue;
    limit = std::max(limit, norm(at(mesh_.target(h)) - at(mesh_.origin[h])));
  }
  if (!std::isfinite(limit)) return 0;
  while (limit > longest && size() - before < max_points) {
    limit = std::max(longest, limit / kStep);
    flip_to_delaunay();
    for (int round = 0; round < kRounds; ++round) {
      check_stop(stop);
      if (split_pass(limit, max_points - (size() - before)) == 0) break;
      flip_changed();
    }
    if (limit > longest) {
      collapse_down_to(kClose * limit, before);
      drop_unused(before);
    }
  }
  return size() - before;
}

/// Forgets the points from `first` on that no triangle uses.
void PatchMesh::drop_unused(std::uint32_t first) {
  std::vector<std::uint32_t> number(size());
  std::uint32_t next = first;
  for (std::uint32_t v = 0; v < size(); ++v) {
    number[v] = v < first ? v : next;
    if (v < first || mesh_.from[v] == kNone32) continue;
    positions_[next] = positions_[v];
    mesh_.from[next] = mesh_.from[v];
    ++next;
  }
  positions_.resize(next);
  mesh_.from.resize(next);
  for (std::uint32_t& v : mesh_.origin) v = number[v];
}

/// Edges inside that patch_defect would object to: those that join corners of one vertex; where
/// there are none, the forbidden ones and of each group of the same all but one.
std::vector<std::uint32_t> PatchMesh::edges_to_split() const {
  using Entry = std::tuple<VertexPair, int, std::uint32_t>;  // identities, inside, half-edge
  std::vector<Entry> edges;
  std::vector<std::uint32_t> closed;
  for (std::uint32_t h = 0; h < mesh_.size(); ++h) {
    if (mesh_.twin[h] != kNone32 && mesh_.twin[h] < h) continue;
    const VertexPair pair = vertex_pair(identity(mesh_.origin[h]), identity(mesh_.target(h)));
    edges.emplace_back(pair, mesh_.twin[h] == kNone32 ? 0 : 1, h);
    if (pair[0] == pair[1] && mesh_.twin[h] != kNone32) closed.push_back(h);
  }
  if (!closed.empty()) return closed;
  std::sort(edges.begin(), edges.end());
  std::vector<std::uint32_t> bad;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto& [pair, inside, h] = edges[i];
    const bool repeats = i > 0 && std::get<0>(edges[i - 1]) == pair;
    if (inside == 0) continue;
    if (repeats || is_forbidden(mesh_.origin[h], mesh_.target(h))) bad.push_back(h);
  }
  return bad;
}

// This ends. No split makes an edge between corners of one vertex, so those go first. Then a new
// vertex repeats an edge only where the two apexes are corners of one vertex; and splitting that
// edge repeats none, for its apexes are the ends of the edge that was split before. (The bound is
// for rims that have an edge from a vertex to itself, which cannot be mended.)
std::uint32_t PatchMesh::split_forbidden_chords() {
  std::uint32_t count = 0;
  constexpr int kRounds = 64;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<std::uint32_t> bad = edges_to_split();
    if (bad.empty()) break;
    std::vector<VertexPair> ends;
    for (const std::uint32_t h : bad) ends.push_back({mesh_.origin[h], mesh_.target(h)});
    for (const auto& [a, b] : ends) {
      const std::uint32_t h = find_edge(a, b);
      if (h == kNone32 || mesh_.twin[h] == kNone32) continue;
      const Vec3 middle = 0.5 * (at(a) + at(b));
      const Vec3 apexes = 0.5 * (at(mesh_.apex(h)) + at(mesh_.apex(mesh_.twin[h])));
      split(h, at(a) == at(b) ? 0.5 * (middle + apexes) : middle);
      ++count;
    }
  }
  return count;
}

// ---- Flips ---------------------------------------------------------------------------------

namespace {

/// Cosine of the least angle of a triangle; the same for every order of its corners.
double sharpest(std::array<std::uint32_t, 3> t, const std::vector<Vec3>& positions) {
  std::sort(t.begin(), t.end());
  std::array<Vec3, 3> sides;
  std::array<double, 3> lengths{};
  for (int k = 0; k < 3; ++k) {
    sides[k] = positions[t[(k + 1) % 3]] - positions[t[k]];
    lengths[k] = norm(sides[k]);
  }
  double largest = -1.0;
  for (int k = 0; k < 3; ++k) {
    const int before = (k + 2) % 3;
    const double product = lengths[k] * lengths[before];
    largest = std::max(largest, product > 0.0 ? -dot(sides[k], sides[before]) / product : 1.0);
  }
  return largest;
}

/// The angles at c and d over the edge a-b of two triangles.
struct Opposite {
  double sine = 0.0;     ///< of their sum times `lengths`; negative when it exceeds pi
  double lengths = 0.0;  ///< of the four sides at c and d, their product
  bool is_flat = false;  ///< a triangle has an angle of less than 1e-4, perhaps
};

Opposite opposite_angles(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  constexpr double kFlat = 1e-4;
  const Vec3 p = a - c, q = b - c, r = a - d, s = b - d;
  const double pp = squared_norm(p), qq = squared_norm(q), rr = squared_norm(r),
               ss = squared_norm(s), edge = squared_norm(b - a);
  const double upper = norm(cross(p, q));
  const double lower = norm(cross(r, s));
  return {upper * dot(r, s) + lower * dot(p, q), std::sqrt(pp * qq) * std::sqrt(rr * ss),
          !(upper > kFlat * std::max({pp, qq, edge}) && lower > kFlat * std::max({rr, ss, edge}))};
}

/// Whether both angles at c and d over the edge a-b are acute at most and no triangle is flat: told
/// without roots, for most edges. False proves nothing.
bool is_surely_delaunay(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  constexpr double kNotFlat = 1.1e-4 * 1.1e-4;  // above what counts as flat, rounding included
  const Vec3 p = a - c, q = b - c, r = a - d, s = b - d;
  if (!(dot(p, q) >= 0.0 && dot(r, s) >= 0.0)) return false;
  // Before an acute angle the square of the edge is at most the sum of the sides' squares.
  const double upper = squared_norm(p) + squared_norm(q), lower = squared_norm(r) + squared_norm(s);
  return squared_norm(cross(p, q)) > kNotFlat * upper * upper &&
         squared_norm(cross(r, s)) > kNotFlat * lower * lower;
}

}  // namespace

bool PatchMesh::flip_improves(std::uint32_t h) const {
  constexpr double kRounding = 1e-10;
  const std::uint32_t a = mesh_.origin[h];
  const std::uint32_t b = mesh_.target(h);
  const std::uint32_t c = mesh_.apex(h);
  const std::uint32_t d = mesh_.apex(mesh_.twin[h]);
  if (is_surely_delaunay(at(a), at(b), at(c), at(d))) return false;
  const auto [sine, lengths, is_flat] = opposite_angles(at(a), at(b), at(c), at(d));
  const bool is_delaunay = !(sine < -kRounding * lengths);
  if (is_delaunay && !is_flat) return false;
  const double before = std::max(sharpest({a, b, c}, positions_), sharpest({a, b, d}, positions_));
  // Flat triangles have no angles to go by: both cotangents may vanish.
  if (is_delaunay && before < 1.0 - kRounding) return false;
  return std::max(sharpest({c, d, a}, positions_), sharpest({c, d, b}, positions_)) < before;
}

bool PatchMesh::flip_keeps_shape(std::uint32_t h) const {
  constexpr double kCrease = 0.5;  // cos 60 degrees
  const std::uint32_t g = mesh_.twin[h];
  const Vec3 a = at(mesh_.origin[h]);
  const Vec3 b = at(mesh_.target(h));
  const Vec3 c = at(mesh_.apex(h));
  const Vec3 d = at(mesh_.apex(g));
  const Facet upper = facet(a, b, c);
  const Facet lower = facet(b, a, d);
  const Vec3 right = facet(d, b, c).normal;
  const Vec3 left = facet(c, a, d).normal;
  if (right == Vec3{} || left == Vec3{}) return false;
  const Vec3 mean = upper.area * upper.normal + lower.area * lower.normal;
  if (mean == Vec3{}) return true;  // flat triangles have no side to keep
  const double crease = upper.normal == Vec3{} || lower.normal == Vec3{}
                            ? kCrease
                            : std::min(dot(upper.normal, lower.normal), kCrease);
  return dot(right, mean) > 0.0 && dot(left, mean) > 0.0 && dot(right, left) >= crease;
}

std::uint32_t PatchMesh::flip_to_delaunay() {
  is_changed_.assign(mesh_.size() / 3, 1);
  return flip_changed();
}

/// As flip_to_delaunay(), where only triangles that are marked have changed since it ended: no edge
/// between two others is worth a flip now.
std::uint32_t PatchMesh::flip_changed() {
  is_changed_.resize(mesh_.size() / 3, 1);
  std::vector<std::uint32_t> queue;  // goes on while it is gone through
  for (std::uint32_t h = 0; h < mesh_.size(); ++h) {
    if (mesh_.twin[h] != kNone32 && h < mesh_.twin[h]) queue.push_back(h);
  }
  std::vector<std::uint32_t> waiting;  // edges that others, which may go, keep from a flip
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const std::uint32_t h = queue[i];
    const std::uint32_t g = mesh_.twin[h];
    if (g == kNone32 || (is_changed_[h / 3] == 0 && is_changed_[g / 3] == 0)) continue;
    if (!flip_improves(h) || !flip_keeps_shape(h)) continue;
    if (!may_join(mesh_.apex(h), mesh_.apex(g))) {
      waiting.push_back(h);
      continue;
    }
    mesh_.flip(h);
    is_changed_[h / 3] = is_changed_[g / 3] = 1;
    for (const std::uint32_t e : {h, HalfEdges::next(h), g, HalfEdges::next(g)}) queue.push_back(e);
    ++count;
  }
  std::fill(is_changed_.begin(), is_changed_.end(), 0);
  for (const std::uint32_t h : waiting) is_changed_[h / 3] = 1;
  return count;
}

}  // namespace orbweave
