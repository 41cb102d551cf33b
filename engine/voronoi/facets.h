// Chosen facets of a triangulation of space.
#pragma once

#include <cstddef>
#include <cstdint>
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
  const std::vector<std::uint8_t>& bits() const { return bits_; }  ///< per tetrahedron
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

/// Sorts triangles by their corners, which are below `points`: into the lists of the first corners,
/// and each of those few by the others.
void sort_triangles(std::size_t points, std::vector<Triangle>& triangles);

/// All flagged facets: their corners ascending, whichever side that is seen from. Sorted.
std::vector<Triangle> all_triangles(const Tetrahedra& tetrahedra, const FacetFlags& flags);

}  // namespace orbweave::voronoi
