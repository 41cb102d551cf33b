// The triangles of the Cocone algorithm, and which points are sampled well enough for it.
// Amenta, Choi, Dey, Leekha, A Simple Algorithm for Homeomorphic Surface Reconstruction, 2000,
// section 3. Dey, Giesen, Detecting Undersampling in Surface Reconstruction, 2001, section 4.
#pragma once

#include <array>
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

/// For every tetrahedron and each of its vertices: the cosine of the angle between the direction
/// to the tetrahedron's centre and the vertex's normal. Four per tetrahedron.
using Cosines = std::vector<std::array<float, 4>>;
Cosines center_cosines(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                       const Poles& poles, const StopToken* stop = nullptr);

/// The facets whose dual Voronoi edge passes through the cocones of all three vertices: the
/// directions within `angle_rad` of the vertices' tangent planes. Where `flat` is not empty, only
/// well-sampled vertices choose, and each facet has at least one of them: the others' normals tell
/// nothing, and surfaces stay open at their boundaries.
FacetFlags cocone_facets(const Tetrahedra& tetrahedra, const Cosines& cosines,
                         std::span<const std::uint8_t> flat, double angle_rad = kCoconeAngleRad,
                         const StopToken* stop = nullptr);

/// Flags of the points that are sampled well: their Voronoi cells are long and thin along their
/// normals, and neighbours have about the same normals. The others are on or near undersampled
/// regions, boundaries, creases and noise.
std::vector<std::uint8_t> flat_points(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                      const Stars& stars, const Poles& poles,
                                      const Cosines& cosines, const FlatnessOptions& options = {},
                                      const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
