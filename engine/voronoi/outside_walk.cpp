#include "engine/voronoi/outside_walk.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "engine/voronoi/manifold_edges.h"

namespace orbweave::voronoi {
namespace {

std::size_t at(int place) { return static_cast<std::size_t>(place); }

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

class OutsideWalk {
 public:
  OutsideWalk(std::span<const Vec3> points, const Tetrahedra& tetrahedra, StarFinder& stars,
              std::span<const Vec3> normals, const FacetFlags& flags, const FacetLinks& links,
              std::span<const Vec3> outward_normals)
      : points_(points),
        tetrahedra_(tetrahedra),
        stars_(stars),
        normals_(normals),
        flags_(flags),
        links_(links),
        outward_normals_(outward_normals),
        taken_(links.halves() / 2, 0),
        visited_(points.size(), 0),
        sides_(points.size(), 0) {}

  std::vector<Triangle> run(const StopToken* stop) {
    ids_.resize(points_.size());
    std::iota(ids_.begin(), ids_.end(), 0u);
    // Most clouds have one component, and few points are left when it has been walked over.
    const auto first = std::min_element(
        ids_.begin(), ids_.end(), [&](std::uint32_t a, std::uint32_t b) { return is_left(a, b); });
    if (first != ids_.end()) begin_at(*first, stop);
    std::erase_if(ids_, [&](std::uint32_t p) { return visited_[p] != 0; });
    std::sort(ids_.begin(), ids_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return is_left(a, b); });
    for (const std::uint32_t p : ids_)
      if (visited_[p] == 0) begin_at(p, stop);
    keep_manifold_edges(points_, suspects(), triangles_);
    return std::move(triangles_);
  }

 private:
  /// Flags of the ends of edges that may have more than two triangles, or two of one direction: the
  /// taken facets there are not all of one surface, seen from one side.
  std::vector<std::uint8_t> suspects() const {
    std::vector<std::uint8_t> found(points_.size(), 0);
    for (const FacetHalf half : taken_halves_) {
      for (HalfEdge edge = 3 * half; edge < 3 * half + 3; ++edge) {
        const HalfEdge next = links_.across(edge);
        const FacetHalf behind = FacetLinks::opposite(FacetLinks::half_of(next));
        const bool is_edge_of_two =
            FacetLinks::half_of(links_.across(links_.behind(next))) == FacetLinks::opposite(half);
        if (is_edge_of_two && taken_[behind / 2] != behind % 2 + 1) continue;
        found[links_.start(edge)] = found[links_.end(edge)] = 1;
      }
    }
    return found;
  }

  bool is_left(std::uint32_t a, std::uint32_t b) const {
    const Vec3 p = points_[a], q = points_[b];
    return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
  }

  void begin_at(std::uint32_t p, const StopToken* stop) {
    const std::optional<FacetSide> seed = outermost(p);
    if (seed) walk(outer_half(links_.half_of(*seed)), stop);
  }

  /// The side that the outward normals of the corners point to, where they are known.
  FacetHalf outer_half(FacetHalf half) const {
    if (outward_normals_.empty()) return half;
    const Triangle& t = links_.corners(half);
    const Vec3 sum = outward_normals_[t[0]] + outward_normals_[t[1]] + outward_normals_[t[2]];
    return dot(outward(t), sum) < 0.0 ? FacetLinks::opposite(half) : half;
  }

  bool is_new(FacetSide side) const {
    for (const std::uint32_t v : corners_of(tetrahedra_, side))
      if (visited_[v] != 0) return false;
    return true;
  }

  /// The tetrahedron of a star whose centre lies farthest to the left.
  static std::uint32_t leftmost_cell(const Tetrahedra& tetrahedra,
                                     std::span<const std::uint32_t> star) {
    const auto place = [&](std::uint32_t cell) {
      const Vec3 center = tetrahedra.centers[cell];
      const bool is_finite = tetrahedra.is_finite(cell);
      // Tetrahedra at infinity first where they open to the left, last where they do not.
      const int rank = is_finite ? 1 : center.x < 0.0 ? 0 : 2;
      return std::tuple(rank, center.x, center.y, center.z);
    };
    std::uint32_t best = star.front();
    for (const std::uint32_t cell : star)
      if (place(cell) < place(best)) best = cell;
    return best;
  }

  /// The facet at the leftmost point of a component that is seen first from the left.
  std::optional<FacetSide> outermost(std::uint32_t p) {
    const std::span<const std::uint32_t> star = stars_.find(p);
    if (star.empty()) return std::nullopt;
    std::vector<std::uint32_t> reached = {leftmost_cell(tetrahedra_, star)};
    std::optional<FacetSide> best;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (int place = 0; place < 4; ++place) {
        const FacetSide side{reached[i], place};
        if (tetrahedra_.vertices[side.cell][at(place)] == p) continue;
        if (flags_.has(side)) {
          if (is_new(side) && (!best || is_more_left(side, *best))) best = side;
          continue;
        }
        const std::uint32_t next = tetrahedra_.neighbors[side.cell][at(place)];
        if (std::find(reached.begin(), reached.end(), next) == reached.end())
          reached.push_back(next);
      }
    }
    return best;
  }

  bool is_more_left(FacetSide a, FacetSide b) const {
    const auto key = [&](FacetSide side) {
      const Triangle corners = corners_of(tetrahedra_, side);
      return std::tuple(outward(corners).x, sorted(corners));
    };
    return key(a) < key(b);
  }

  Vec3 outward(const Triangle& t) const {
    return normalized(cross(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]));
  }

  /// What a facet says of a point's normal: outward, inward, or nothing where the normals are
  /// more than 60 degrees apart.
  std::int8_t side_at(std::uint32_t point, Vec3 outward_of_facet) const {
    constexpr double kLeastCosine = 0.5;
    const double cosine = dot(normals_[point], outward_of_facet);
    return static_cast<std::int8_t>((cosine > kLeastCosine ? 1 : 0) -
                                    (cosine < -kLeastCosine ? 1 : 0));
  }

  /// What a facet says of the normals of its corners.
  using CornerSides = std::array<std::int8_t, 3>;
  CornerSides sides_at_corners(FacetHalf half) const {
    const Triangle& corners = links_.corners(half);
    const Vec3 normal = links_.normal(half);
    return {side_at(corners[0], normal), side_at(corners[1], normal), side_at(corners[2], normal)};
  }

  void take(FacetHalf half, const CornerSides& sides) {
    taken_[half / 2] = static_cast<std::uint8_t>(half % 2 + 1);
    const Triangle& corners = links_.corners(half);
    triangles_.push_back(corners);
    for (std::size_t k = 0; k < 3; ++k) {
      visited_[corners[k]] = 1;
      if (sides_[corners[k]] == 0) sides_[corners[k]] = sides[k];
    }
    queue_.push_back(half);
    taken_halves_.push_back(half);
  }

  /// Whether a facet would turn a point inside out: the walk has come to the back of the surface
  /// through one of its holes.
  bool is_back(FacetHalf half, const CornerSides& sides) const {
    const Triangle& corners = links_.corners(half);
    return sides_[corners[0]] * sides[0] < 0 || sides_[corners[1]] * sides[1] < 0 ||
           sides_[corners[2]] * sides[2] < 0;
  }

  /// Breadth first; the edges of a facet in the order of their corners, which no storage decides.
  void walk(FacetHalf seed, const StopToken* stop) {
    queue_.clear();
    take(seed, sides_at_corners(seed));
    for (std::size_t i = 0; i < queue_.size(); ++i) {
      if (i % kStopBlock == 0) check_stop(stop);
      const HalfEdge first = 3 * queue_[i];
      for (HalfEdge edge = first; edge < first + 3; ++edge) step_over(edge);
    }
  }

  void step_over(HalfEdge edge) {
    const FacetHalf next = FacetLinks::half_of(links_.across(edge));
    if (taken_[next / 2] != 0) return;
    const CornerSides sides = sides_at_corners(next);
    if (!is_back(next, sides) && !folds_back(points_, links_, edge)) take(next, sides);
  }

  std::span<const Vec3> points_;
  const Tetrahedra& tetrahedra_;
  StarFinder& stars_;
  std::span<const Vec3> normals_;
  const FacetFlags& flags_;
  const FacetLinks& links_;
  std::span<const Vec3> outward_normals_;  // empty: not known
  std::vector<std::uint8_t> taken_;        // per facet: 1 or 2, from its first or second side
  std::vector<std::uint32_t> ids_;
  std::vector<std::uint8_t> visited_;
  std::vector<std::int8_t> sides_;  // 1: a point's normal is outward, -1: inward, 0: not known
  std::vector<FacetHalf> queue_, taken_halves_;
  std::vector<Triangle> triangles_;
};

}  // namespace

std::vector<Triangle> walk_outside(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                   StarFinder& stars, std::span<const Vec3> normals,
                                   const FacetFlags& flags, const FacetLinks& links,
                                   std::span<const Vec3> outward, const StopToken* stop) {
  std::vector<Triangle> triangles =
      OutsideWalk(points, tetrahedra, stars, normals, flags, links, outward).run(stop);
  sort_triangles(points.size(), triangles);
  return triangles;
}

}  // namespace orbweave::voronoi
