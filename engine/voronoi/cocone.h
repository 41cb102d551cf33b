// The triangles of the Cocone algorithm, and which points are sampled well enough for it.
// Amenta, Choi, Dey, Leekha, A Simple Algorithm for Homeomorphic Surface Reconstruction, 2000,
// section 3. Dey, Giesen, Detecting Undersampling in Surface Reconstruction, 2001, section 4.
#pragma once

#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "engine/voronoi/facets.h"
#include "engine/voronoi/poles.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

/// The published angle.
inline constexpr double kCoconeAngleRad = std::numbers::pi / 8.0;

struct FlatnessOptions {
  /// Height of a Voronoi cell (distance to the nearer pole) over its radius (farthest point inside
  /// the cocone) from which a point is sampled well. More: more points count as undersampled.
  double least_height = 1.2;
  /// Largest angle between the normal of a well-sampled point and those of its neighbours.
  double most_turn_rad = std::numbers::pi / 3.0;
};

/// Where the centre of a tetrahedron lies, seen from its four vertices, whose normals point up: a
/// bit for each vertex in each of three groups of four.
struct CenterSides {
  std::uint16_t bits = 0;

  /// Above the cocone of the vertex at this place: more than the cocone's angle above its tangent
  /// plane.
  bool is_above(int place) const { return ((bits >> place) & 1) != 0; }
  bool is_below(int place) const { return ((bits >> (4 + place)) & 1) != 0; }  ///< the cocone
  /// Below the tangent plane, inside the cocone or not.
  bool is_under_plane(int place) const { return ((bits >> (8 + place)) & 1) != 0; }
};

/// Of all tetrahedra. For those at infinity: of the direction that they open to.
std::vector<CenterSides> center_sides(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                      const Poles& poles, double angle_rad = kCoconeAngleRad,
                                      const StopToken* stop = nullptr);

/// Which facets' dual Voronoi edges pass through the cocones of which of their vertices. Kept with
/// the first tetrahedron of each facet: bit 4 i + j says it of the facet opposite place i and the
/// vertex at place j.
using CoconeEdges = std::vector<std::uint16_t>;
CoconeEdges cocone_edges(const Tetrahedra& tetrahedra, std::span<const CenterSides> sides,
                         const StopToken* stop = nullptr);

/// The facets whose dual Voronoi edge passes through the cocones of all three vertices: the
/// directions within an angle of the vertices' tangent planes. Where `flat` is not empty, only
/// well-sampled vertices choose, and each facet has at least one of them: the others' normals tell
/// nothing, and surfaces stay open at their boundaries.
FacetFlags cocone_facets(const Tetrahedra& tetrahedra, const CoconeEdges& edges,
                         std::span<const std::uint8_t> flat, const StopToken* stop = nullptr);

/// Flags of the points that are sampled well: their Voronoi cells are long and thin along their
/// normals, and neighbours have about the same normals. The others are on or near undersampled
/// regions, boundaries, creases and noise. `sides` and `edges`: of the published angle.
std::vector<std::uint8_t> flat_points(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                      const Poles& poles, std::span<const CenterSides> sides,
                                      const CoconeEdges& edges, const FlatnessOptions& options = {},
                                      const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
