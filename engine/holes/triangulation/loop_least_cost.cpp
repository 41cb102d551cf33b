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
  // A triangle whose area overflows has a normal that is no number: it bends as much as can be.
  const double apart = 1.0 - dot(a, b);
  const double steps = kSteps * (apart < 2.0 ? std::max(apart, 0.0) : 2.0);
  // As std::lround, which is a call: what is left of the steps has no rounding.
  const auto whole = static_cast<std::int64_t>(steps);
  return static_cast<std::uint32_t>(whole + (steps - static_cast<double>(whole) >= 0.5 ? 1 : 0));
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

constexpr double kSame = 1e-9;
/// An area of more than so many times another is larger for certain, however both were rounded.
constexpr double kSurely = 1.0 + 1e-6;

bool is_less(const Cost& a, const Cost& b) {
  if (a.bend != b.bend) return a.bend < b.bend;
  if (std::abs(a.area - b.area) > kSame * b.area) return a.area < b.area;
  return a.length < b.length * (1.0 - kSame);
}

/// Whether no cost that bends at least this much and has at least this area is less.
bool is_no_less(std::uint32_t bend, double area, const Cost& than) {
  return bend > than.bend || (bend == than.bend && area - than.area > kSame * than.area);
}

/// Liepa's way, O(n^3): the best triangle at an edge is chosen without regard to the triangle that
/// will lie across the edge.
class LeastCost {
 public:
  LeastCost(const LoopInSpace& loop, const LoopChords& chords, std::span<const std::uint32_t> ring,
            std::span<const Vec3> behind)
      : chords_(chords), ring_(ring), behind_(behind), n_(ring.size()) {
    for (const std::uint32_t corner : ring) corners_.push_back(loop.corners[corner]);
    cells_.resize(n_ * n_);
    bends_.assign(n_ * n_, kImpossible);
    for (std::size_t i = 0; i + 1 < n_; ++i) set(i, i + 1, {{0, 0.0, 0.0}, 0, behind_[i]});
  }

  bool solve() {
    for (std::size_t span = 2; span < n_; ++span) {
      for (std::size_t i = 0; i + span < n_; ++i) choose(i, i + span);
    }
    return largest_bend() != kImpossible;
  }

  std::uint32_t largest_bend() const { return cells_[n_ - 1].cost.bend; }

  void append(std::vector<CornerTriangle>& out) const {
    std::vector<std::pair<std::size_t, std::size_t>> edges{{0, n_ - 1}};
    while (!edges.empty()) {
      const auto [i, j] = edges.back();
      edges.pop_back();
      if (j - i < 2) continue;
      const std::size_t k = cells_[i * n_ + j].apex;
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
  /// At (i, j) and at (j, i): what is looked at one after the other then lies so in memory.
  void set(std::size_t i, std::size_t j, const Cell& cell) {
    cells_[i * n_ + j] = cells_[j * n_ + i] = cell;
    bends_[i * n_ + j] = bends_[j * n_ + i] = cell.cost.bend;
  }

  /// With the triangle i, k, j; bends more than `most` where that much is sure before all is known.
  Cell with_apex(std::size_t i, std::size_t k, std::size_t j, const Cost& parts, double chord,
                 std::uint32_t most) const {
    const bool closes = i == 0 && j + 1 == n_;
    const Facet face = facet(corners_[i], corners_[k], corners_[j]);
    Cell cell{parts, static_cast<std::uint32_t>(k), face.normal};
    const std::uint32_t own = face.normal == Vec3{}
                                  ? kFlatBend
                                  : std::max(bend(face.normal, cells_[i * n_ + k].normal),
                                             bend(face.normal, cells_[j * n_ + k].normal));
    cell.cost.bend = std::max(parts.bend, own);
    if (own > most) return cell;
    if (closes) cell.cost.bend = std::max(cell.cost.bend, bend(face.normal, behind_[n_ - 1]));
    cell.cost.area += face.area;
    cell.cost.length += chord;
    return cell;
  }

  /// Whether a triangle has more than that area, without what its normal would cost.
  bool is_larger(std::size_t i, std::size_t k, std::size_t j, double area) const {
    return squared_norm(cross(corners_[k] - corners_[i], corners_[j] - corners_[i])) >
           4.0 * area * area;
  }

  /// The cost with an apex that is likely to be good: what costs clearly more need not be looked
  /// at. Its area is taken for so much larger that no candidate that may decide is left out.
  Cost bound(std::size_t i, std::size_t j, double chord) const {
    constexpr double kSlack = 1e-6;  // far above kSame, however many candidates follow
    constexpr std::size_t kFew = 6;
    Cost least;
    if (j - i < kFew) return least;
    for (const std::size_t k :
         {std::size_t{cells_[i * n_ + j - 1].apex}, std::size_t{cells_[(i + 1) * n_ + j].apex}}) {
      if (k <= i || k >= j) continue;
      const std::uint32_t parts = std::max(bends_[i * n_ + k], bends_[j * n_ + k]);
      if (parts == kImpossible) continue;
      const Cost cost = with_apex(i, k, j, sum(cells_[i * n_ + k].cost, cells_[j * n_ + k].cost),
                                  chord, kImpossible)
                            .cost;
      if (is_less(cost, least)) least = cost;
    }
    least.area *= 1.0 + kSlack;
    return least;
  }

  void choose(std::size_t i, std::size_t j) {
    const bool closes = i == 0 && j + 1 == n_;
    if (!closes && !chords_.allows(ring_[i], ring_[j])) return;
    const double chord = closes ? 0.0 : squared_norm(corners_[j] - corners_[i]);
    const Cost bounded = bound(i, j, chord);
    std::uint32_t most = bounded.bend;  // of what may still be the best
    Cell best;
    for (std::size_t k = i + 1; k < j; ++k) {
      const std::uint32_t least = std::max(bends_[i * n_ + k], bends_[j * n_ + k]);
      if (least == kImpossible || least > most) continue;
      const Cost parts = sum(cells_[i * n_ + k].cost, cells_[j * n_ + k].cost);
      if (is_no_less(least, parts.area, best.cost) || is_no_less(least, parts.area, bounded))
        continue;
      if (least == best.cost.bend && is_larger(i, k, j, kSurely * best.cost.area - parts.area))
        continue;
      const Cell cell = with_apex(i, k, j, parts, chord, most);
      if (cell.cost.bend > most || !is_less(cell.cost, best.cost)) continue;
      best = cell;
      most = std::min(most, best.cost.bend);
    }
    set(i, j, best);
  }

  const LoopChords& chords_;
  std::span<const std::uint32_t> ring_;
  std::span<const Vec3> behind_;
  std::size_t n_;
  std::vector<Vec3> corners_;  ///< of the ring
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> bends_;
};

/// O(n^4): the best parts are known for every triangle that may lie at an edge, so that the
/// largest bend is the least of all triangulations. What bends more than `most_bend`, the largest
/// bend of a triangulation that is known, is not looked at.
class LeastCostByApex {
 public:
  LeastCostByApex(const LoopInSpace& loop, const LoopChords& chords,
                  std::span<const std::uint32_t> ring, std::span<const Vec3> behind,
                  std::uint32_t most_bend)
      : loop_(loop),
        chords_(chords),
        ring_(ring),
        behind_(behind),
        n_(ring.size()),
        most_bend_(most_bend) {
    first_.resize(n_ * n_);
    least_bend_.assign(n_ * n_, kImpossible);
    std::size_t cells = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t j = i + 1; j < n_; ++j) {
        first_[i * n_ + j] = cells;
        cells += j - i - 1;
      }
      if (i + 1 < n_) least_bend_[i * n_ + i + 1] = 0;
    }
    cells_.resize(cells);
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
    return cells_[first_[i * n_ + j] + (apex - i - 1)];
  }
  const Cell& cell(std::size_t i, std::size_t j, std::size_t apex) const {
    return cells_[first_[i * n_ + j] + (apex - i - 1)];
  }
  Vec3 at(std::size_t i) const { return loop_.corners[ring_[i]]; }

  /// The best part behind the edge i-j, before which a face with `normal` lies.
  Part best(std::size_t i, std::size_t j, Vec3 normal) const {
    Part best;
    if (j - i == 1) best.cost.bend = bend(normal, behind_[i]);
    for (std::size_t apex = i + 1; apex < j; ++apex) {
      const Cell& candidate = cell(i, j, apex);
      if (candidate.cost.bend == kImpossible ||
          is_no_less(candidate.cost.bend, candidate.cost.area, best.cost))
        continue;
      Cost cost = candidate.cost;
      cost.bend = std::max(cost.bend, bend(normal, candidate.normal));
      if (is_less(cost, best.cost)) best = {cost, static_cast<std::uint32_t>(apex)};
    }
    return best;
  }

  void fill(std::size_t i, std::size_t j) {
    const bool closes = i == 0 && j + 1 == n_;
    if (!closes && !chords_.allows(ring_[i], ring_[j])) return;
    std::uint32_t& least = least_bend_[i * n_ + j];
    for (std::size_t apex = i + 1; apex < j; ++apex) {
      if (std::max(least_bend_[i * n_ + apex], least_bend_[apex * n_ + j]) > most_bend_) continue;
      const Facet face = facet(at(i), at(apex), at(j));
      const Part left = best(i, apex, face.normal);
      const Part right = best(apex, j, face.normal);
      Cost cost = sum(left.cost, right.cost);
      if (face.normal == Vec3{}) cost.bend = std::max(cost.bend, kFlatBend);
      if (cost.bend > most_bend_) continue;
      cost.area += face.area;
      if (!closes) cost.length += squared_norm(at(j) - at(i));
      cell(i, j, apex) = {cost, left.apex, right.apex, face.normal};
      least = std::min(least, cost.bend);
    }
  }

  const LoopInSpace& loop_;
  const LoopChords& chords_;
  std::span<const std::uint32_t> ring_;
  std::span<const Vec3> behind_;
  std::size_t n_;
  std::uint32_t most_bend_;
  std::vector<std::size_t> first_;         ///< per edge i-j: its first cell
  std::vector<std::uint32_t> least_bend_;  ///< per edge i-j: of its cells
  std::vector<Cell> cells_;
};

}  // namespace

bool triangulate_exactly(const LoopInSpace& loop, const LoopChords& chords,
                         std::span<const std::uint32_t> ring, std::span<const Vec3> behind,
                         std::vector<CornerTriangle>& out) {
  LeastCost least(loop, chords, ring, behind);
  if (!least.solve()) return false;
  if (ring.size() > kLeastBendCorners) {
    least.append(out);
    return true;
  }
  LeastCostByApex exact(loop, chords, ring, behind, least.largest_bend());
  if (!exact.solve()) return false;
  exact.append(out);
  return true;
}

}  // namespace orbweave
