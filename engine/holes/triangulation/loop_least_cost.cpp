// The triangulation of a loop of least cost: the largest bend, then the area, then short chords.
// Barequet, Sharir: Filling Gaps in the Boundary of a Polyhedron, CAGD 1995; Liepa: Filling Holes
// in Meshes, SGP 2003, section 3.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/holes/triangulation/loop_chords.h"

namespace orbweave {
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

/// Of two parts beside a triangle.
Cost sum(const Cost& a, const Cost& b) {
  return {std::max(a.bend, b.bend), a.area + b.area, a.length + b.length};
}

bool is_less(const Cost& a, const Cost& b) {
  constexpr double kSame = 1e-9;
  if (a.bend != b.bend) return a.bend < b.bend;
  if (std::abs(a.area - b.area) > kSame * b.area) return a.area < b.area;
  return a.length < b.length * (1.0 - kSame);
}

/// Liepa's way, O(n^3): the best triangle at an edge is chosen without regard to the triangle that
/// will lie across the edge.
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
      Cost cost = sum(left.cost, right.cost);
      if (cost.bend == kImpossible || cost.bend > best.cost.bend) continue;
      const Facet face = facet(at(i), at(k), at(j));
      const std::uint32_t own = face.normal == Vec3{} ? kFlatBend
                                                      : std::max(bend(face.normal, left.normal),
                                                                 bend(face.normal, right.normal));
      cost.bend = std::max({cost.bend, own, closes ? bend(face.normal, behind_[n_ - 1]) : 0U});
      cost.area += face.area;
      cost.length += chord;
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

/// O(n^4): the best parts are known for every triangle that may lie at an edge, so that the
/// largest bend is the least of all triangulations.
class LeastCostByApex {
 public:
  LeastCostByApex(const LoopInSpace& loop, const LoopChords& chords,
                  std::span<const std::uint32_t> ring, std::span<const Vec3> behind)
      : loop_(loop), chords_(chords), ring_(ring), behind_(behind), n_(ring.size()) {
    cells_.resize(n_ * n_ * n_);
  }

  bool solve() {
    for (std::size_t span = 2; span < n_; ++span) {
      for (std::size_t i = 0; i + span < n_; ++i) fill(i, i + span);
    }
    return best(0, n_ - 1, behind_[n_ - 1]).cost.bend != kImpossible;
  }

  void append(std::vector<CornerTriangle>& out) const {
    struct Edge {
      std::size_t i, j, apex;
    };
    std::vector<Edge> edges{{0, n_ - 1, best(0, n_ - 1, behind_[n_ - 1]).apex}};
    while (!edges.empty()) {
      const auto [i, j, apex] = edges.back();
      edges.pop_back();
      if (j - i < 2) continue;
      out.push_back({ring_[i], ring_[apex], ring_[j]});
      edges.push_back({i, apex, cell(i, j, apex).left});
      edges.push_back({apex, j, cell(i, j, apex).right});
    }
  }

 private:
  /// The best triangulation of the corners from i to j with the triangle i, apex, j.
  struct Cell {
    Cost cost;
    std::uint32_t left = 0;  ///< apex of the triangle across its edge from i
    std::uint32_t right = 0;
    Vec3 normal;
  };
  struct Part {
    Cost cost;
    std::uint32_t apex = 0;
  };
  Cell& cell(std::size_t i, std::size_t j, std::size_t apex) {
    return cells_[(i * n_ + j) * n_ + apex];
  }
  const Cell& cell(std::size_t i, std::size_t j, std::size_t apex) const {
    return cells_[(i * n_ + j) * n_ + apex];
  }
  Vec3 at(std::size_t i) const { return loop_.corners[ring_[i]]; }

  /// The best part behind the edge i-j, before which a face with `normal` lies.
  Part best(std::size_t i, std::size_t j, Vec3 normal) const {
    Part best;
    if (j - i == 1) best.cost.bend = bend(normal, behind_[i]);
    for (std::size_t apex = i + 1; apex < j; ++apex) {
      const Cell& candidate = cell(i, j, apex);
      if (candidate.cost.bend == kImpossible || candidate.cost.bend > best.cost.bend) continue;
      Cost cost = candidate.cost;
      cost.bend = std::max(cost.bend, bend(normal, candidate.normal));
      if (is_less(cost, best.cost)) best = {cost, static_cast<std::uint32_t>(apex)};
    }
    return best;
  }

  void fill(std::size_t i, std::size_t j) {
    const bool closes = i == 0 && j + 1 == n_;
    if (!closes && !chords_.allows(ring_[i], ring_[j])) return;
    for (std::size_t apex = i + 1; apex < j; ++apex) {
      const Facet face = facet(at(i), at(apex), at(j));
      const Part left = best(i, apex, face.normal);
      const Part right = best(apex, j, face.normal);
      Cost cost = sum(left.cost, right.cost);
      if (cost.bend == kImpossible) continue;
      if (face.normal == Vec3{}) cost.bend = std::max(cost.bend, kFlatBend);
      cost.area += face.area;
      if (!closes) cost.length += squared_norm(at(j) - at(i));
      cell(i, j, apex) = {cost, left.apex, right.apex, face.normal};
    }
  }

  const LoopInSpace& loop_;
  const LoopChords& chords_;
  std::span<const std::uint32_t> ring_;
  std::span<const Vec3> behind_;
  std::size_t n_;
  std::vector<Cell> cells_;
};

}  // namespace

bool triangulate_exactly(const LoopInSpace& loop, const LoopChords& chords,
                         std::span<const std::uint32_t> ring, std::span<const Vec3> behind,
                         std::vector<CornerTriangle>& out) {
  const auto run = [&](auto least) {
    if (!least.solve()) return false;
    least.append(out);
    return true;
  };
  if (ring.size() <= kLeastBendCorners) return run(LeastCostByApex(loop, chords, ring, behind));
  return run(LeastCost(loop, chords, ring, behind));
}

}  // namespace orbweave
