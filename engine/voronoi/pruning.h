// Removal of triangles that stick out of a surface.
// Amenta, Bern, Surface Reconstruction by Voronoi Filtering, 1999, section 6.
#pragma once

#include <span>

#include "engine/voronoi/facet_links.h"
#include "engine/voronoi/facets.h"
#include "engine/voronoi/star_finder.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

/// Removes facets at sharp edges until none can go: edges whose facets all lie within a right angle
/// (a single facet, above all). The papers assume closed surfaces, of which nothing else is left;
/// here a facet stays that an umbrella at one of its corners needs, and so do those at corners
/// without an umbrella: boundaries of open surfaces are not eaten away. `links` are those of the
/// flagged facets, before and after.
void prune_sharp_edges(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                       StarFinder& stars, std::span<const Vec3> normals, FacetFlags& flags,
                       FacetLinks& links, const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
