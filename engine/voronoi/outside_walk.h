// The surface that is seen from outside.
// Amenta, Bern, Surface Reconstruction by Voronoi Filtering, 1999, section 6 (manifold extraction).
#pragma once

#include <span>
#include <vector>

#include "engine/voronoi/facet_links.h"
#include "engine/voronoi/facets.h"
#include "engine/voronoi/star_finder.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave::voronoi {

/// The outermost layer of the flagged facets: walks over them along their outer sides, from the
/// leftmost point of each component on, which do not cross edges where the surface folds back, nor
/// come to the back of a point (`normals`: of the points, to either side). Corners are
/// counter-clockwise seen from outside. No edge has more than two triangles, no directed edge more
/// than one. `points`: the leading vertices of `tetrahedra` that a component may begin at. `links`:
/// of the flagged facets. `outward`: normals of the points that say which side of a component is
/// outside; empty: the one that is seen first from the left. Smallest corner first, sorted.
std::vector<Triangle> walk_outside(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                                   StarFinder& stars, std::span<const Vec3> normals,
                                   const FacetFlags& flags, const FacetLinks& links,
                                   std::span<const Vec3> outward = {},
                                   const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
