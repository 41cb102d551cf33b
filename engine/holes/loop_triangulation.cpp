#include "engine/holes/loop_triangulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/holes/loop_chords.h"

namespace orbweave {

// ---- Chords --------------------------------------------------------------------------------

LoopChords::LoopChords(const LoopInSpace& loop)
    : vertices_(loop.vertices), forbidden_(loop.forbidden) {
  std::vector<std::uint32_t> sorted(vertices_.begin(), vertices_.end());
  std::sort(sorted.begin(), sorted.end());
  touches_ = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
  if (!touches_) return;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    more_.push_back(vertex_pair(vertices_[i], vertices_[(i + 1) % vertices_.size()]));
  }
  std::sort(more_.begin(), more_.end());
}

bool LoopChords::allows(std::uint32_t a, std::uint32_t b) const {
  const VertexPair pair = vertex_pair(vertices_[a], vertices_[b]);
  return pair[0] != pair[1] && !std::binary_search(forbidden_.begin(), forbidden_.end(), pair) &&
         !std::binary_search(more_.begin(), more_.end(), pair);
}

bool LoopChords::forbid_repeated(std::span<const CornerTriangle> triangles) {
  if (!touches_) return false;
  const auto n = static_cast<std::uint32_t>(vertices_.size());
  std::vector<VertexPair> chords;
  for (const CornerTriangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k];
      const std::uint32_t b = t[(k + 1) % 3];
      if (a > b || b - a == 1 || b - a == n - 1) continue;  // one of two sides; no rim edges
      chords.push_back(vertex_pair(vertices_[a], vertices_[b]));
    }
  }
  std::sort(chords.begin(), chords.end());
  const std::size_t before = more_.size();
  for (std::size_t i = 1; i < chords.size(); ++i) {
    if (chords[i] == chords[i - 1]) more_.push_back(chords[i]);
  }
  const bool found = more_.size() > before;
  std::sort(more_.begin(), more_.end());
  return found;
}

Facet facet(Vec3 a, Vec3 b, Vec3 c) {
  // Area below this share of the longest edge's square is rounding.
  constexpr double kFlat = 1e-10;
  const Vec3 normal = cross(b - a, c - a);
  const double doubled = norm(normal);
  const double longest = std::max({squared_norm(b - a), squared_norm(c - b), squared_norm(a - c)});
  if (!(doubled > kFlat * longest)) return {Vec3{}, 0.5 * doubled};
  return {normal / doubled, 0.5 * doubled};
}

// ---- The least cost -------------------------------------------------------------------------

namespace {

// 1 - cos of an angle between normals in steps of 2^-30 (0.04 mrad from zero): angles that differ
// by rounding only are equal, and the area decides.
constexpr double kSteps = 1 << 30;
constexpr std::uint32_t kFlatBend = 3U << 30;  // a triangle without area
constexpr std::uint32_t kImpossible = std::numeric_limits<std::uint32_t>::max();

std::uint32_t bend(Vec3 a, Vec3 b) {
  if (a == Vec3{} || b == Vec3{}) return 0;
  return static_cast<std::uint32_t>(std::lround(kSteps * std::clamp(1.0 - dot(a, b), 0.0, 2.0)));
}

struct Cost {
  std::uint32_t bend = kImpossible;
  double area = 0.0;
  double length = 0.0;  ///< squares of chords
};

bool is_less(const Cost& a, const Cost& b) {
  constexpr double kSame = 1e-9;
  if (a.bend != b.bend) return a.bend < b.bend;
  if (std::abs(a.area - b.area) > kSame * b.area) return a.area < b.area;
  return a.length < b.length * (1.0 - kSame);
}

class LeastCost {
 public:
  LeastCost(const LoopInSpace& loop, const LoopChords& chords, std::span<const std::uint32_t> ring,
            std::span<const Vec3> behind)
      : loop_(loop), chords_(chords), ring_(ring), behind_(behind), n_(ring.size()) {
    cells_.resize(n_ * n_);
    for (std::size_t i = 0; i + 1 < n_; ++i) {
      cell(i, i + 1).cost.bend = 0;
      cell(i, i + 1).normal = behind_[i];
    }
  }

  bool solve() {
    for (std::size_t span = 2; span < n_; ++span) {
      for (std::size_t i = 0; i + span < n_; ++i) choose(i, i + span);
    }
    return cell(0, n_ - 1).cost.bend != kImpossible;
  }

  void append(std::vector<CornerTriangle>& out) const {
    std::vector<std::pair<std::size_t, std::size_t>> edges{{0, n_ - 1}};
    while (!edges.empty()) {
      const auto [i, j] = edges.back();
      edges.pop_back();
      if (j - i < 2) continue;
      const std::size_t k = cell(i, j).apex;
      out.push_back({ring_[i], ring_[k], ring_[j]});
      edges.emplace_back(i, k);
      edges.emplace_back(k, j);
    }
  }

 private:
  /// The best triangulation of the corners from i to j.
  struct Cell {
    Cost cost;
    std::uint32_t apex = 0;  ///< of the triangle at the edge i-j
    Vec3 normal;             ///< of that triangle, or of the face behind the rim
  };
  Cell& cell(std::size_t i, std::size_t j) { return cells_[i * n_ + j]; }
  const Cell& cell(std::size_t i, std::size_t j) const { return cells_[i * n_ + j]; }
  Vec3 at(std::size_t i) const { return loop_.corners[ring_[i]]; }

  void choose(std::size_t i, std::size_t j) {
    const bool closes = i == 0 && j + 1 == n_;
    if (!closes && !chords_.allows(ring_[i], ring_[j])) return;
    const double chord = closes ? 0.0 : squared_norm(at(j) - at(i));
    Cell best;
    for (std::size_t k = i + 1; k < j; ++k) {
      const Cell& left = cell(i, k);
      const Cell& right = cell(k, j);
      Cost cost{std::max(left.cost.bend, right.cost.bend), left.cost.area + right.cost.area,
                left.cost.length + right.cost.length + chord};
      if (cost.bend == kImpossible || cost.bend > best.cost.bend) continue;
      const Facet face = facet(at(i), at(k), at(j));
      const std::uint32_t own = face.normal == Vec3{} ? kFlatBend
                                                      : std::max(bend(face.normal, left.normal),
                                                                 bend(face.normal, right.normal));
      cost.bend = std::max({cost.bend, own, closes ? bend(face.normal, behind_[n_ - 1]) : 0U});
      cost.area += face.area;
      if (is_less(cost, best.cost)) best = {cost, static_cast<std::uint32_t>(k), face.normal};
    }
    cell(i, j) = best;
  }

  const LoopInSpace& loop_;
  const LoopChords& chords_;
  std::span<const std::uint32_t> ring_;
  std::span<const Vec3> behind_;
  std::size_t n_;
  std::vector<Cell> cells_;
};

std::vector<CornerTriangle> attempt(const LoopInSpace& loop, const LoopChords& chords,
                                    std::uint32_t exact_corners) {
  // Where so many corners have no ear that may be cut, the exact way is still affordable (1 s).
  constexpr std::size_t kMostExact = 640;
  std::vector<CornerTriangle> triangles;
  const LoopRest rest = cut_ears(loop, chords, std::max(exact_corners, 3U), triangles);
  if (rest.ring.size() > std::max<std::size_t>(exact_corners, kMostExact)) return {};
  if (!triangulate_exactly(loop, chords, rest.ring, rest.behind, triangles)) return {};
  return triangles;
}

}  // namespace

bool triangulate_exactly(const LoopInSpace& loop, const LoopChords& chords,
                         std::span<const std::uint32_t> ring, std::span<const Vec3> behind,
                         std::vector<CornerTriangle>& out) {
  LeastCost least(loop, chords, ring, behind);
  if (!least.solve()) return false;
  least.append(out);
  return true;
}

std::vector<CornerTriangle> triangulate_loop(const LoopInSpace& loop, std::uint32_t exact_corners) {
  const std::size_t n = loop.corners.size();
  if (n < 3 || loop.vertices.size() != n) return {};
  if (!loop.rim_normals.empty() && loop.rim_normals.size() != n) return {};
  LoopChords chords(loop);
  // Chords that were repeated are forbidden in the next attempt; more of them than a loop touches
  // itself are not met in practice.
  constexpr int kAttempts = 16;
  for (int i = 0; i < kAttempts; ++i) {
    std::vector<CornerTriangle> triangles = attempt(loop, chords, exact_corners);
    if (!chords.forbid_repeated(triangles)) return triangles;
  }
  return {};
}

}  // namespace orbweave
