// Tight Cocone: a watertight surface whose vertices are input points.
// Dey, Goswami, Tight Cocone: A Water-tight Surface Reconstructor, 2003, sections 3 and 4.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/cocone.h"
#include "engine/voronoi/facets.h"
#include "engine/voronoi/poles.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

/// The boundary of the tetrahedra that are inside.
///
/// Marking: the cocone triangles at a well-sampled point separate its tetrahedra into those above
/// and those below. Tetrahedra at infinity are outside;
/// from point to point, shared tetrahedra tell which side of a point is outside. A tetrahedron that
/// its points disagree on is what most of them say, and inside where the numbers are equal.
///
/// Peeling: what is marked outside goes, and from there, the largest circumball first, what is not
/// marked, unless it is the last tetrahedron of one of its points. Nothing that is marked inside
/// goes. Then edges of more than two triangles are closed: the tetrahedra between, on all sides of
/// the edge but one, are put back.
///
/// Every edge has exactly two triangles. Corners are counter-clockwise seen from outside. Smallest
/// corner first, sorted.
/// `sides` and `edges`: of the angle that `cocone` was chosen by.
std::vector<Triangle> tight_cocone(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                   const Stars& stars, const Poles& poles,
                                   std::span<const CenterSides> sides, const CoconeEdges& edges,
                                   const FacetFlags& cocone, std::span<const std::uint8_t> flat,
                                   const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
