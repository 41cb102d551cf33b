#include "engine/voronoi/facets.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "engine/voronoi/manifold_edges.h"

namespace orbweave::voronoi {
namespace {

std::size_t at(int place) { return static_cast<std::size_t>(place); }

/// The vertex of a tetrahedron that is none of the three.
std::uint32_t fourth(const std::array<std::uint32_t, 4>& cell, std::uint32_t a, std::uint32_t b,
                     std::uint32_t c) {
  for (const std::uint32_t v : cell)
    if (v != a && v != b && v != c) return v;
  return kInfinite;
}

/// The corner of the facet beside an edge.
std::uint32_t apex_of(const Tetrahedra& tetrahedra, FacetSide side, std::uint32_t a,
                      std::uint32_t b) {
  for (const std::uint32_t v : corners_of(tetrahedra, side))
    if (v != a && v != b) return v;
  return kInfinite;
}

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

class OutsideWalk {
 public:
  OutsideWalk(std::span<const Vec3> points, const Tetrahedra& tetrahedra, const Stars& stars,
              std::span<const Vec3> normals, const FacetFlags& flags)
      : points_(points),
        tetrahedra_(tetrahedra),
        stars_(stars),
        normals_(normals),
        flags_(flags),
        taken_(tetrahedra),
        visited_(points.size(), 0),
        sides_(points.size(), 0) {}

  std::vector<Triangle> run(const StopToken* stop) {
    std::vector<std::uint32_t> order(points_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      const Vec3 p = points_[a], q = points_[b];
      return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
    });
    for (const std::uint32_t p : order) {
      if (visited_[p] != 0) continue;
      const std::optional<FacetSide> seed = outermost(p);
      if (seed) walk(*seed, stop);
    }
    return std::move(triangles_);
  }

 private:
  bool is_new(FacetSide side) const {
    for (const std::uint32_t v : corners_of(tetrahedra_, side))
      if (visited_[v] != 0) return false;
    return true;
  }

  /// The tetrahedron at p whose centre lies farthest to the left.
  std::uint32_t leftmost_cell(std::uint32_t p) const {
    const auto place = [&](std::uint32_t cell) {
      const Vec3 center = tetrahedra_.centers[cell];
      const bool is_finite = tetrahedra_.is_finite(cell);
      // Tetrahedra at infinity first where they open to the left, last where they do not.
      const int rank = is_finite ? 1 : center.x < 0.0 ? 0 : 2;
      return std::tuple(rank, center.x, center.y, center.z);
    };
    std::uint32_t best = stars_.of(p).front();
    for (const std::uint32_t cell : stars_.of(p))
      if (place(cell) < place(best)) best = cell;
    return best;
  }

  /// The facet at the leftmost point of a component that is seen first from the left.
  std::optional<FacetSide> outermost(std::uint32_t p) {
    if (stars_.of(p).empty()) return std::nullopt;
    std::vector<std::uint32_t> reached = {leftmost_cell(p)};
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
      return std::tuple(outward(side).x, sorted(corners_of(tetrahedra_, side)));
    };
    return key(a) < key(b);
  }

  Vec3 outward(FacetSide side) const {
    const Triangle t = corners_of(tetrahedra_, side);
    return normalized(cross(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]));
  }

  /// What a facet says of a point's normal: outward, inward, or nothing where the normals are
  /// more than 60 degrees apart.
  std::int8_t side_at(std::uint32_t point, Vec3 outward_of_facet) const {
    constexpr double kLeastCosine = 0.5;
    const double cosine = dot(normals_[point], outward_of_facet);
    return cosine > kLeastCosine ? 1 : cosine < -kLeastCosine ? -1 : 0;
  }

  void take(FacetSide side) {
    taken_.set(side);
    const Triangle corners = corners_of(tetrahedra_, side);
    triangles_.push_back(smallest_first(corners));
    const Vec3 normal = outward(side);
    for (const std::uint32_t v : corners) {
      visited_[v] = 1;
      if (sides_[v] == 0) sides_[v] = side_at(v, normal);
    }
    queue_.push_back(side);
  }

  /// Whether the facet would turn a point inside out: the walk has come to the back of the surface
  /// through one of its holes.
  bool is_back(FacetSide side) const {
    const Vec3 normal = outward(side);
    const Triangle corners = corners_of(tetrahedra_, side);
    return std::any_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
      return sides_[v] != 0 && side_at(v, normal) == -sides_[v];
    });
  }

  /// Breadth first; the edges of a facet in the order of their corners, which no storage decides.
  void walk(FacetSide seed, const StopToken* stop) {
    queue_.clear();
    take(seed);
    for (std::size_t i = 0; i < queue_.size(); ++i) {
      if (i % kStopBlock == 0) check_stop(stop);
      const FacetSide side = queue_[i];
      const Triangle corners = corners_of(tetrahedra_, side);
      const auto first =
          static_cast<int>(std::min_element(corners.begin(), corners.end()) - corners.begin());
      for (int k = 0; k < 3; ++k) {
        const int edge = (first + k) % 3;
        const FacetSide next = next_around(tetrahedra_, flags_, side, edge);
        if (taken_.has(next) || is_back(next)) continue;
        if (!folds_back(points_, tetrahedra_, side, edge, next)) take(next);
      }
    }
  }

  std::span<const Vec3> points_;
  const Tetrahedra& tetrahedra_;
  const Stars& stars_;
  std::span<const Vec3> normals_;
  const FacetFlags& flags_;
  FacetFlags taken_;
  std::vector<std::uint8_t> visited_;
  std::vector<std::int8_t> sides_;  // 1: a point's normal is outward, -1: inward, 0: not known
  std::vector<FacetSide> queue_;
  std::vector<Triangle> triangles_;
};

}  // namespace

Triangle corners_of(const Tetrahedra& tetrahedra, FacetSide side) {
  const auto& vertices = tetrahedra.vertices[side.cell];
  const auto& facet = kFacet[at(side.place)];
  return {vertices[at(facet[0])], vertices[at(facet[2])], vertices[at(facet[1])]};
}

FacetSide next_around(const Tetrahedra& tetrahedra, const FacetFlags& flags, FacetSide side,
                      int edge) {
  const Triangle corners = corners_of(tetrahedra, side);
  const std::uint32_t a = corners[at(edge)], b = corners[at((edge + 1) % 3)];
  std::uint32_t x = corners[at((edge + 2) % 3)];
  std::uint32_t cell = side.cell;
  while (true) {
    const int place = tetrahedra.place_of_vertex(cell, x);
    const FacetSide found{cell, place};
    if (flags.has(found)) return found;
    x = fourth(tetrahedra.vertices[cell], a, b, x);
    cell = tetrahedra.neighbors[cell][at(place)];
  }
}

bool folds_back(std::span<const Vec3> points, const Tetrahedra& tetrahedra, FacetSide side,
                int edge, FacetSide next) {
  const Triangle corners = corners_of(tetrahedra, side);
  const std::uint32_t a = corners[at(edge)], b = corners[at((edge + 1) % 3)];
  const std::uint32_t x = corners[at((edge + 2) % 3)];
  const std::uint32_t y = apex_of(tetrahedra, next, a, b);
  if (x == y) return true;
  const Vec3 along = points[b] - points[a];
  const Vec3 u = cross(along, points[x] - points[a]);
  const Vec3 v = cross(along, points[y] - points[a]);
  return dot(u, v) > 0.0 && dot(along, cross(u, v)) < 0.0;
}

std::vector<Triangle> walk_outside(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                   const Stars& stars, std::span<const Vec3> normals,
                                   const FacetFlags& flags, const StopToken* stop) {
  std::vector<Triangle> triangles =
      OutsideWalk(points, tetrahedra, stars, normals, flags).run(stop);
  keep_manifold_edges(points, triangles);
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

std::vector<Triangle> all_triangles(const Tetrahedra& tetrahedra, const FacetFlags& flags) {
  std::vector<Triangle> triangles;
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (!flags.has_any(c)) continue;
    for (int place = 0; place < 4; ++place) {
      const FacetSide side{c, place};
      if (!flags.has(side) || tetrahedra.neighbors[c][at(place)] < c) continue;
      triangles.push_back(sorted(corners_of(tetrahedra, side)));
    }
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

}  // namespace orbweave::voronoi
