// The poles of points on a surface: the farthest corners of their Voronoi cells.
// Amenta, Bern, Surface Reconstruction by Voronoi Filtering, 1999, section 4.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

/// A pole is the centre of a tetrahedron at the point.
struct Poles {
  /// Unit vectors to the first pole, or, on the convex hull, where the first pole is at infinity,
  /// the mean outward normal of the hull's facets there. Zero at points that are vertices of
  /// nothing. Which side of the surface it is on differs from point to point.
  std::vector<Vec3> normals;
  std::vector<std::uint32_t> first;   ///< tetrahedron; one at infinity on the convex hull
  std::vector<std::uint32_t> second;  ///< tetrahedron; kNone: no corner lies on the other side
};

Poles find_poles(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                 const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
