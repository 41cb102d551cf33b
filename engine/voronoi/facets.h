// Chosen facets of a triangulation of space, and the surfaces that they form.
// Amenta, Bern, Surface Reconstruction by Voronoi Filtering, 1999, section 6 (manifold extraction).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave::voronoi {

/// A facet as one of its two tetrahedra sees it.
struct FacetSide {
  std::uint32_t cell = 0;
  int place = 0;  ///< of the tetrahedron's vertex that is not the facet's
};

/// A flag per facet, kept with both of its tetrahedra.
class FacetFlags {
 public:
  explicit FacetFlags(const Tetrahedra& tetrahedra)
      : tetrahedra_(&tetrahedra), bits_(tetrahedra.size(), 0) {}

  bool has(FacetSide side) const { return ((bits_[side.cell] >> side.place) & 1) != 0; }
  bool has_any(std::uint32_t cell) const { return bits_[cell] != 0; }
  void set(FacetSide side) {
    const FacetSide back = opposite(side);
    bits_[side.cell] |= bit(side.place);
    bits_[back.cell] |= bit(back.place);
  }
  void clear(FacetSide side) {
    const FacetSide back = opposite(side);
    bits_[side.cell] &= static_cast<std::uint8_t>(~bit(side.place));
    bits_[back.cell] &= static_cast<std::uint8_t>(~bit(back.place));
  }
  /// The same facet as the other tetrahedron sees it.
  FacetSide opposite(FacetSide side) const {
    return {tetrahedra_->neighbors[side.cell][static_cast<std::size_t>(side.place)],
            tetrahedra_->mirror_place(side.cell, side.place)};
  }

 private:
  static std::uint8_t bit(int place) { return static_cast<std::uint8_t>(1 << place); }
  const Tetrahedra* tetrahedra_;
  std::vector<std::uint8_t> bits_;
};

/// The corners of a facet, counter-clockwise seen from inside the tetrahedron of that side.
Triangle corners_of(const Tetrahedra& tetrahedra, FacetSide side);

/// The first flagged facet on the way around the edge from `corners[edge]` to the next corner of
/// `side`, beginning inside the tetrahedron of that side: the facet that forms the surface with
/// this one there, seen from that side. It is the opposite of `side` where no other is flagged.
FacetSide next_around(const Tetrahedra& tetrahedra, const FacetFlags& flags, FacetSide side,
                      int edge);

/// Whether the way around an edge from a facet to `next`, the next flagged one, is more than three
/// right angles, beginning on this side: the surface folds back there, or ends.
bool folds_back(std::span<const Vec3> points, const Tetrahedra& tetrahedra, FacetSide side,
                int edge, FacetSide next);

/// The outermost layer of the flagged facets: walks over them along their outer sides, from the
/// leftmost point of each component on,
/// and do not cross edges where the surface folds back, nor to the back of a point (`normals`: of
/// the points, to either side). Corners are counter-clockwise seen from outside. No edge
/// has more than two triangles, no directed edge more than one. `points`: the leading vertices of
/// `tetrahedra` that a component may begin at. Smallest corner first, sorted.
std::vector<Triangle> walk_outside(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                   const Stars& stars, std::span<const Vec3> normals,
                                   const FacetFlags& flags, const StopToken* stop = nullptr);

/// All flagged facets: their corners ascending, whichever side that is seen from. Sorted.
std::vector<Triangle> all_triangles(const Tetrahedra& tetrahedra, const FacetFlags& flags);

}  // namespace orbweave::voronoi
