// Whether the flagged facets at a point go all around it, as an umbrella does.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/facets.h"
#include "engine/voronoi/star_finder.h"
#include "engine/voronoi/tetrahedra.h"

namespace orbweave::voronoi {

/// The side of a tetrahedron at a point, seen from the point's umbrella.
enum class UmbrellaSide : std::uint8_t { kNeither, kAbove, kBelow };

/// Separates the tetrahedra at points. Above is where a point's normal points to. Facets that are
/// flagged separate the topmost tetrahedron at a point from the lowest one exactly where some of
/// them form a disc around the point.
class Umbrellas {
 public:
  /// All arguments have to outlive the object.
  Umbrellas(std::span<const Vec3> points, const Tetrahedra& tetrahedra, StarFinder& stars,
            std::span<const Vec3> normals, const FacetFlags& flags);

  /// Whether there is an umbrella at p; sides() holds the sides of the tetrahedra at p then, in the
  /// order of the star, and kNeither between layers of facets.
  bool separate(std::uint32_t p);
  std::span<const UmbrellaSide> sides() const { return sides_; }

 private:
  bool flood(std::uint32_t p, std::uint32_t from, UmbrellaSide side);
  double height(std::uint32_t p, std::uint32_t cell) const;

  std::span<const Vec3> points_;
  const Tetrahedra& tetrahedra_;
  StarFinder& stars_;
  std::span<const Vec3> normals_;
  const FacetFlags& flags_;
  std::vector<UmbrellaSide> sides_;
  std::vector<std::uint32_t> waiting_;
};

}  // namespace orbweave::voronoi
