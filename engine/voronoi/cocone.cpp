#include "engine/voronoi/cocone.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace orbweave::voronoi {
namespace {

/// Whether an edge between directions of these cosines passes within the angle of the tangent
/// plane, whose sine is given.
bool passes(float a, float b, float sine) {
  return std::min(a, b) <= sine && std::max(a, b) >= -sine;
}

/// What a point's Voronoi cell is like.
struct CellShape {
  float radius = 0.0F;  ///< distance to the farthest point of the cell in the cocone
  float height = 0.0F;  ///< distance to the nearer pole
};

/// One end of a Voronoi edge, seen from a point.
struct EdgeEnd {
  std::uint32_t cell = 0;  ///< one at infinity: the edge does not end
  float cosine = 0.0F;
};

class Flatness {
 public:
  Flatness(std::span<const Vec3> points, const Tetrahedra& tetrahedra, const Stars& stars,
           const Poles& poles, const Cosines& cosines, const FlatnessOptions& options)
      : points_(points),
        tetrahedra_(tetrahedra),
        stars_(stars),
        poles_(poles),
        cosines_(cosines),
        sine_(static_cast<float>(std::sin(kCoconeAngleRad))),
        least_height_(static_cast<float>(options.least_height)),
        least_cosine_(std::cos(options.most_turn_rad)),
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
  /// Calls visit(vertex, end, end, others) for every Voronoi edge and each of its three points.
  template <class Visit>
  void visit_edges(const StopToken* stop, const Visit& visit) {
    for (std::uint32_t c = 0; c < tetrahedra_.size(); ++c) {
      if (c % kStopBlock == 0) check_stop(stop);
      for (int place = 0; place < 4; ++place) {
        const std::uint32_t other = tetrahedra_.neighbors[c][static_cast<std::size_t>(place)];
        if (c < other) visit_edge(c, other, place, visit);
      }
    }
  }

  template <class Visit>
  void visit_edge(std::uint32_t c, std::uint32_t other, int place, const Visit& visit) {
    const auto& facet = kFacet[static_cast<std::size_t>(place)];
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = tetrahedra_.vertices[c][static_cast<std::size_t>(facet[k])];
      if (corners[k] == kInfinite) return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const auto here = static_cast<std::size_t>(facet[k]);
      const auto there = static_cast<std::size_t>(tetrahedra_.place_of_vertex(other, corners[k]));
      const EdgeEnd a{c, cosines_[c][here]}, b{other, cosines_[other][there]};
      if (passes(a.cosine, b.cosine, sine_))
        visit(corners[k], a, b, std::array{corners[(k + 1) % 3], corners[(k + 2) % 3]});
    }
  }

  float distance(std::uint32_t cell) const {
    return tetrahedra_.is_finite(cell) ? static_cast<float>(tetrahedra_.radii[cell])
                                       : std::numeric_limits<float>::infinity();
  }

  /// The distance of the farthest point of an edge within the cocone of p: an end, or where the
  /// edge passes through the tangent plane.
  float farthest_in_cocone(std::uint32_t p, const EdgeEnd& a, const EdgeEnd& b) const {
    float farthest = 0.0F;
    for (const EdgeEnd& end : {a, b})
      if (std::abs(end.cosine) <= sine_) farthest = std::max(farthest, distance(end.cell));
    if ((a.cosine < 0.0F) == (b.cosine < 0.0F)) return farthest;
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
    return std::isfinite(share) ? static_cast<float>(norm(from + share * along)) : 0.0F;
  }

  void measure(const StopToken* stop) {
    visit_edges(stop, [&](std::uint32_t p, const EdgeEnd& a, const EdgeEnd& b,
                          const std::array<std::uint32_t, 2>& others) {
      shapes_[p].radius = std::max(shapes_[p].radius, farthest_in_cocone(p, a, b));
      for (const std::uint32_t q : others)
        if (!agree(p, q)) turns_[q] = 1;
    });
    for (std::uint32_t p = 0; p < shapes_.size(); ++p)
      if (poles_.second[p] != kNone) shapes_[p].height = distance(poles_.second[p]);
  }

  bool agree(std::uint32_t p, std::uint32_t q) const {
    return std::abs(dot(poles_.normals[p], poles_.normals[q])) >= least_cosine_;
  }

  bool is_thin(std::uint32_t p) const {
    return shapes_[p].radius > 0.0F && shapes_[p].height >= least_height_ * shapes_[p].radius;
  }

  /// A thin cell beside a well-sampled point of about the same normal is one itself.
  void expand(std::vector<std::uint8_t>& flat) const {
    std::vector<std::uint32_t> candidates;
    for (std::uint32_t q = 0; q < flat.size(); ++q)
      if (flat[q] == 0 && is_thin(q)) candidates.push_back(q);
    for (bool grows = true; grows;) {
      std::vector<std::uint32_t> grown;
      for (const std::uint32_t q : candidates)
        if (is_beside_flat(q, flat)) grown.push_back(q);
      for (const std::uint32_t q : grown) flat[q] = 1;
      grows = !grown.empty();
      std::erase_if(candidates, [&](std::uint32_t q) { return flat[q] != 0; });
    }
  }

  /// Whether the cocone of a well-sampled point of about the same normal reaches into the cell.
  bool is_beside_flat(std::uint32_t q, std::span<const std::uint8_t> flat) const {
    for (const std::uint32_t c : stars_.of(q)) {
      for (int place = 0; place < 4; ++place) {
        const std::uint32_t other = tetrahedra_.neighbors[c][static_cast<std::size_t>(place)];
        if (tetrahedra_.vertices[c][static_cast<std::size_t>(place)] == q) continue;
        for (const int k : kFacet[static_cast<std::size_t>(place)]) {
          const std::uint32_t p = tetrahedra_.vertices[c][static_cast<std::size_t>(k)];
          if (p == q || p == kInfinite || flat[p] == 0 || !agree(p, q)) continue;
          const auto there = static_cast<std::size_t>(tetrahedra_.place_of_vertex(other, p));
          if (passes(cosines_[c][static_cast<std::size_t>(k)], cosines_[other][there], sine_))
            return true;
        }
      }
    }
    return false;
  }

  std::span<const Vec3> points_;
  const Tetrahedra& tetrahedra_;
  const Stars& stars_;
  const Poles& poles_;
  const Cosines& cosines_;
  float sine_;
  float least_height_;
  double least_cosine_;
  std::vector<CellShape> shapes_;
  std::vector<std::uint8_t> turns_;  // a neighbour's normal differs
};

}  // namespace

Cosines center_cosines(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                       const Poles& poles, const StopToken* stop) {
  Cosines cosines(tetrahedra.size());
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    const bool is_finite = tetrahedra.is_finite(c);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint32_t p = tetrahedra.vertices[c][k];
      if (p == kInfinite) continue;
      const Vec3 direction = is_finite ? (tetrahedra.centers[c] - points[p]) / tetrahedra.radii[c]
                                       : tetrahedra.centers[c];
      cosines[c][k] = static_cast<float>(dot(direction, poles.normals[p]));
    }
  }
  return cosines;
}

FacetFlags cocone_facets(const Tetrahedra& tetrahedra, const Cosines& cosines,
                         std::span<const std::uint8_t> flat, double angle_rad,
                         const StopToken* stop) {
  const auto sine = static_cast<float>(std::sin(angle_rad));
  FacetFlags flags(tetrahedra);
  const auto is_chosen = [&](std::uint32_t c, std::uint32_t other, int place) {
    bool by_one = flat.empty();
    for (const int k : kFacet[static_cast<std::size_t>(place)]) {
      const std::uint32_t p = tetrahedra.vertices[c][static_cast<std::size_t>(k)];
      if (p == kInfinite) return false;
      if (!flat.empty() && flat[p] == 0) continue;
      const auto there = static_cast<std::size_t>(tetrahedra.place_of_vertex(other, p));
      if (!passes(cosines[c][static_cast<std::size_t>(k)], cosines[other][there], sine))
        return false;
      by_one = true;
    }
    return by_one;
  };
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    for (int place = 0; place < 4; ++place) {
      const std::uint32_t other = tetrahedra.neighbors[c][static_cast<std::size_t>(place)];
      if (c < other && is_chosen(c, other, place)) flags.set({c, place});
    }
  }
  return flags;
}

std::vector<std::uint8_t> flat_points(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                      const Stars& stars, const Poles& poles,
                                      const Cosines& cosines, const FlatnessOptions& options,
                                      const StopToken* stop) {
  return Flatness(points, tetrahedra, stars, poles, cosines, options).find(stop);
}

}  // namespace orbweave::voronoi
