#include "engine/voronoi/cocone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/geometry/unit_scale.h"
#include "io/box.h"

namespace orbweave::voronoi {
namespace {

CenterSides sides_of(std::uint32_t cell, std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                     const Poles& poles, float sine) {
  CenterSides sides;
  const bool is_finite = tetrahedra.is_finite(cell);
  const Vec3 center = tetrahedra.centers[cell];
  const double radius = is_finite ? tetrahedra.radii[cell] : 1.0;
  for (int place = 0; place < 4; ++place) {
    const std::uint32_t p = tetrahedra.vertices[cell][static_cast<std::size_t>(place)];
    if (p == kInfinite) continue;
    const Vec3 to_center = is_finite ? center - points[p] : center;
    const auto cosine = static_cast<float>(dot(to_center, poles.normals[p]) / radius);
    const int bits =
        (cosine > sine ? 1 : 0) | (cosine < -sine ? 16 : 0) | (cosine < 0.0F ? 256 : 0);
    sides.bits = static_cast<std::uint16_t>(sides.bits | (bits << place));
  }
  return sides;
}

/// Bits of the vertices, by their places, whose cocones the edge passes through that is dual to the
/// facet opposite `place`.
unsigned edges_of_facet(const Tetrahedra& tetrahedra, std::span<const CenterSides> sides,
                        std::uint32_t cell, std::uint32_t other, int place) {
  const auto& vertices = tetrahedra.vertices[cell];
  const auto& others = tetrahedra.vertices[other];
  unsigned passing = 0;
  for (const int k : kFacet[static_cast<std::size_t>(place)]) {
    const std::uint32_t p = vertices[static_cast<std::size_t>(k)];
    if (p == kInfinite) return 0;
    const int there = place_in(others, p);
    const unsigned both = (sides[cell].bits >> k) & (sides[other].bits >> there);
    passing |= ((both & 0x11U) == 0 ? 1U : 0U) << k;  // not both above, nor both below
  }
  return passing;
}

/// What a point's Voronoi cell is like: lengths, scaled into the range of floats.
struct CellShape {
  float radius = 0.0F;  ///< distance to the farthest point of the cell in the cocone
  float height = 0.0F;  ///< distance to the nearer pole
};

/// One end of a Voronoi edge, seen from a point.
struct EdgeEnd {
  std::uint32_t cell = 0;  ///< one at infinity: the edge does not end
  bool is_in_cocone = false;
  bool is_under_plane = false;
};

class Flatness {
 public:
  Flatness(std::span<const Vec3> points, const Tetrahedra& tetrahedra, const Poles& poles,
           std::span<const CenterSides> sides, const CoconeEdges& edges,
           const FlatnessOptions& options)
      : points_(points),
        tetrahedra_(tetrahedra),
        poles_(poles),
        sides_(sides),
        edges_(edges),
        least_height_(static_cast<float>(options.least_height)),
        least_cosine_(std::cos(options.most_turn_rad)),
        scale_(scale_of(points)),
        shapes_(points.size()),
        turns_(points.size(), 0) {}

  std::vector<std::uint8_t> find(const StopToken* stop) {
    measure(stop);
    std::vector<std::uint8_t> flat(shapes_.size());
    for (std::uint32_t p = 0; p < flat.size(); ++p) flat[p] = is_thin(p) && turns_[p] == 0;
    expand(flat);
    return flat;
  }

 private:
  /// A Voronoi edge: the facet of the tetrahedron opposite a place.
  struct Edge {
    std::uint32_t cell = 0;
    int place = 0;
    unsigned passing = 0;  ///< the vertices whose cocones it passes through
  };

  /// Calls visit(edge) for every Voronoi edge in the cocone of a vertex.
  template <class Visit>
  void visit_edges(const StopToken* stop, const Visit& visit) const {
    for (std::uint32_t c = 0; c < edges_.size(); ++c) {
      if (c % kStopBlock == 0) check_stop(stop);
      if (edges_[c] == 0) continue;
      for (int place = 0; place < 4; ++place) {
        const unsigned passing = (static_cast<unsigned>(edges_[c]) >> (4 * place)) & 15U;
        if (passing != 0) visit(Edge{c, place, passing});
      }
    }
  }

  static double scale_of(std::span<const Vec3> points) {
    Box bounds;
    for (const Vec3 p : points) bounds.extend(p);
    const Vec3 extent = bounds.extent();
    return unit_scale(std::max({extent.x, extent.y, extent.z}));
  }

  EdgeEnd end_of(std::uint32_t cell, int place) const {
    const CenterSides sides = sides_[cell];
    return {cell, !sides.is_above(place) && !sides.is_below(place), sides.is_under_plane(place)};
  }

  float distance(std::uint32_t cell) const {
    return tetrahedra_.is_finite(cell) ? static_cast<float>(scale_ * tetrahedra_.radii[cell])
                                       : std::numeric_limits<float>::infinity();
  }

  /// The distance of the farthest point of an edge within the cocone of p: an end, or where the
  /// edge passes through the tangent plane.
  float farthest_in_cocone(std::uint32_t p, const EdgeEnd& a, const EdgeEnd& b) const {
    float farthest = 0.0F;
    for (const EdgeEnd& end : {a, b})
      if (end.is_in_cocone) farthest = std::max(farthest, distance(end.cell));
    if (a.is_under_plane == b.is_under_plane) return farthest;
    return std::max(farthest, distance_in_plane(p, a.cell, b.cell));
  }

  /// How far from p the edge passes through the tangent plane of p.
  float distance_in_plane(std::uint32_t p, std::uint32_t a, std::uint32_t b) const {
    if (!tetrahedra_.is_finite(a)) std::swap(a, b);
    if (!tetrahedra_.is_finite(a)) return 0.0F;
    const Vec3 from = tetrahedra_.centers[a] - points_[p];
    const Vec3 along = tetrahedra_.is_finite(b) ? tetrahedra_.centers[b] - tetrahedra_.centers[a]
                                                : tetrahedra_.centers[b];
    const double share = -dot(from, poles_.normals[p]) / dot(along, poles_.normals[p]);
    return std::isfinite(share) ? static_cast<float>(scale_ * norm(from + share * along)) : 0.0F;
  }

  void measure(const StopToken* stop) {
    visit_edges(stop, [&](const Edge& edge) { measure_edge(edge); });
    for (std::uint32_t p = 0; p < shapes_.size(); ++p)
      if (poles_.second[p] != kNone) shapes_[p].height = distance(poles_.second[p]);
  }

  void measure_edge(const Edge& edge) {
    const auto& vertices = tetrahedra_.vertices[edge.cell];
    const std::uint32_t other =
        tetrahedra_.neighbors[edge.cell][static_cast<std::size_t>(edge.place)];
    const auto& facet = kFacet[static_cast<std::size_t>(edge.place)];
    std::array<std::uint32_t, 3> corner{};
    std::array<unsigned, 3> passes{};
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = vertices[static_cast<std::size_t>(facet[k])];
      passes[k] = (edge.passing >> facet[k]) & 1U;
      if (passes[k] == 0) continue;
      const std::uint32_t p = corner[k];
      float& radius = shapes_[p].radius;
      radius = std::max(
          radius, farthest_in_cocone(p, end_of(edge.cell, facet[k]),
                                     end_of(other, place_in(tetrahedra_.vertices[other], p))));
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      if ((passes[k] | passes[next]) == 0 || agree(corner[k], corner[next])) continue;
      if (passes[k] != 0) turns_[corner[next]] = 1;
      if (passes[next] != 0) turns_[corner[k]] = 1;
    }
  }

  bool agree(std::uint32_t p, std::uint32_t q) const {
    return std::abs(dot(poles_.normals[p], poles_.normals[q])) >= least_cosine_;
  }

  bool is_thin(std::uint32_t p) const {
    return shapes_[p].radius > 0.0F && shapes_[p].height >= least_height_ * shapes_[p].radius;
  }

  /// Pairs of a thin cell that is not flat yet, and a point of about the same normal whose cocone
  /// reaches into it.
  struct Reach {
    std::uint32_t from = 0, to = 0;
  };

  std::vector<Reach> reaches(std::span<const std::uint8_t> flat) const {
    std::vector<std::uint8_t> can_turn(flat.size());
    for (std::uint32_t q = 0; q < flat.size(); ++q) can_turn[q] = flat[q] == 0 && is_thin(q);
    std::vector<Reach> found;
    visit_edges(nullptr, [&](const Edge& edge) {
      const auto& vertices = tetrahedra_.vertices[edge.cell];
      for (const int k : kFacet[static_cast<std::size_t>(edge.place)]) {
        const std::uint32_t q = vertices[static_cast<std::size_t>(k)];
        if (can_turn[q] == 0) continue;
        for (const int j : kFacet[static_cast<std::size_t>(edge.place)]) {
          const std::uint32_t p = vertices[static_cast<std::size_t>(j)];
          if (j == k || ((edge.passing >> j) & 1U) == 0) continue;
          if ((flat[p] != 0 || can_turn[p] != 0) && agree(p, q)) found.push_back({p, q});
        }
      }
    });
    return found;
  }

  /// A thin cell beside a well-sampled point of about the same normal is one itself.
  void expand(std::vector<std::uint8_t>& flat) const {
    std::vector<Reach> waiting = reaches(flat);
    for (bool grows = true; grows;) {
      grows = false;
      for (const Reach& reach : waiting) {
        if (flat[reach.from] == 0 || flat[reach.to] != 0) continue;
        flat[reach.to] = 1;
        grows = true;
      }
      std::erase_if(waiting, [&](const Reach& reach) { return flat[reach.to] != 0; });
    }
  }

  std::span<const Vec3> points_;
  const Tetrahedra& tetrahedra_;
  const Poles& poles_;
  std::span<const CenterSides> sides_;
  const CoconeEdges& edges_;
  float least_height_;
  double least_cosine_;
  double scale_;  // takes lengths into the range of floats
  std::vector<CellShape> shapes_;
  std::vector<std::uint8_t> turns_;  // a neighbour's normal differs
};

}  // namespace

std::vector<CenterSides> center_sides(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                      const Poles& poles, double angle_rad, const StopToken* stop) {
  const auto sine = static_cast<float>(std::sin(angle_rad));
  std::vector<CenterSides> sides(tetrahedra.size());
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    sides[c] = sides_of(c, points, tetrahedra, poles, sine);
  }
  return sides;
}

CoconeEdges cocone_edges(const Tetrahedra& tetrahedra, std::span<const CenterSides> sides,
                         const StopToken* stop) {
  CoconeEdges edges(tetrahedra.size());
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    unsigned bits = 0;
    for (int place = 0; place < 4; ++place) {
      const std::uint32_t other = tetrahedra.neighbors[c][static_cast<std::size_t>(place)];
      if (c < other) bits |= edges_of_facet(tetrahedra, sides, c, other, place) << (4 * place);
    }
    edges[c] = static_cast<std::uint16_t>(bits);
  }
  return edges;
}

FacetFlags cocone_facets(const Tetrahedra& tetrahedra, const CoconeEdges& edges,
                         std::span<const std::uint8_t> flat, const StopToken* stop) {
  FacetFlags flags(tetrahedra);
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    if (edges[c] == 0) continue;
    unsigned choosing = 15U;  // the vertices that have a say
    for (unsigned k = 0; k < 4 && !flat.empty(); ++k) {
      const std::uint32_t p = tetrahedra.vertices[c][k];
      if (p != kInfinite && flat[p] == 0) choosing &= ~(1U << k);
    }
    for (int place = 0; place < 4; ++place) {
      const unsigned passing = (static_cast<unsigned>(edges[c]) >> (4 * place)) & 15U;
      const unsigned asked = choosing & ~(1U << place);
      if (passing != 0 && asked != 0 && (asked & ~passing) == 0) flags.set({c, place});
    }
  }
  return flags;
}

std::vector<std::uint8_t> flat_points(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                      const Poles& poles, std::span<const CenterSides> sides,
                                      const CoconeEdges& edges, const FlatnessOptions& options,
                                      const StopToken* stop) {
  return Flatness(points, tetrahedra, poles, sides, edges, options).find(stop);
}

}  // namespace orbweave::voronoi
