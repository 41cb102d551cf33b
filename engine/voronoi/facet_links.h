// The flagged facets of a triangulation by their neighbours: what follows each other around an
// edge is found once, not each time that a walk comes by.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/facets.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave::voronoi {

/// A flagged facet as one of its two tetrahedra sees it, by number. Numbers 2 f and 2 f + 1 are the
/// two sides of one facet.
using FacetHalf = std::uint32_t;

/// An edge of a facet seen from one side: number 3 h + k of the edge from corner k of half h.
using HalfEdge = std::uint32_t;

class FacetLinks {
 public:
  FacetLinks(std::span<const Vec3> points, const Tetrahedra& tetrahedra, const FacetFlags& flags,
             const StopToken* stop = nullptr);

  std::uint32_t halves() const { return static_cast<std::uint32_t>(sides_.size()); }
  static FacetHalf opposite(FacetHalf half) { return half ^ 1U; }
  FacetSide side(FacetHalf half) const { return sides_[half]; }
  /// Counter-clockwise seen from inside the tetrahedron of that side, the smallest first.
  const Triangle& corners(FacetHalf half) const { return corners_[half]; }
  /// The unit normal on the side that the corners are counter-clockwise seen from.
  Vec3 normal(FacetHalf half) const {
    return half % 2 == 0 ? normals_[half / 2] : -1.0 * normals_[half / 2];
  }
  bool is_there(FacetHalf half) const { return across_[3 * half] != kGone; }

  /// The edge of the facet that forms the surface with this one there: the first one on the way
  /// around the edge, beginning on this side. Of the same facet's other side where there is no
  /// other facet.
  HalfEdge across(HalfEdge edge) const { return across_[edge]; }
  static FacetHalf half_of(HalfEdge edge) { return edge / 3; }
  /// The same edge of the same facet, seen from the other side.
  static HalfEdge behind(HalfEdge edge) { return 3 * opposite(half_of(edge)) + 2 - edge % 3; }
  std::uint32_t start(HalfEdge edge) const { return corners_[edge / 3][edge % 3]; }
  std::uint32_t end(HalfEdge edge) const { return corners_[edge / 3][(edge % 3 + 1) % 3]; }
  /// The corner that is not the edge's.
  std::uint32_t apex(HalfEdge edge) const { return corners_[edge / 3][(edge % 3 + 2) % 3]; }

  /// Takes the facet of a half away: those beside it follow each other then.
  void remove(FacetHalf half);

  /// The half of a flagged facet.
  FacetHalf half_of(FacetSide side) const { return half_at_[slot(side)]; }

 private:
  static constexpr std::uint32_t kGone = 0xffffffffu;

  void number(const Tetrahedra& tetrahedra, const FacetFlags& flags);
  void add(FacetSide side, const Triangle& corners);
  std::size_t slot(FacetSide side) const;
  void link_by_corners();
  void join(HalfEdge a, HalfEdge b) {
    across_[a] = b;
    across_[b] = a;
  }
  void link(const Tetrahedra& tetrahedra, HalfEdge edge);
  HalfEdge edge_of(FacetHalf half, std::uint32_t start) const {
    const Triangle& corners = corners_[half];
    return 3 * half + (corners[0] == start ? 0U : corners[1] == start ? 1U : 2U);
  }
  bool has(std::uint32_t cell, int place) const { return ((flags_[cell] >> place) & 1) != 0; }

  std::vector<FacetSide> sides_;
  std::vector<Triangle> corners_;
  std::vector<Vec3> normals_;  // per facet, of its first half
  std::vector<HalfEdge> across_;
  std::vector<std::uint8_t> flags_;   // per tetrahedron: its flagged facets
  std::vector<std::uint32_t> first_;  // per tetrahedron: of its facets in half_at_
  std::vector<FacetHalf> half_at_;
};

/// Whether the facets beside an edge certainly form an angle of more than a right one, so that the
/// surface does not fold back there, whichever of the two one looks from.
inline bool is_certainly_open(const FacetLinks& links, HalfEdge edge) {
  constexpr double kLeastCosine = 1e-6;
  return dot(links.normal(FacetLinks::half_of(edge)),
             links.normal(FacetLinks::half_of(links.across(edge)))) > kLeastCosine;
}

/// Whether the way around an edge to the facet that forms the surface with this one is more than
/// three right angles, beginning on this side: the surface folds back there, or ends.
bool folds_back(std::span<const Vec3> points, const FacetLinks& links, HalfEdge edge);

}  // namespace orbweave::voronoi
