// Fewer triangles for a mesh, with vertices that have to stay.
//
// Garland and Heckbert, Surface Simplification Using Quadric Error Metrics, 1997, as meshoptimizer
// does it: edges collapse into one of their ends, so vertices stay where they are.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

struct SimplifyLimits {
  std::size_t triangles = 0;  ///< stop at so many triangles
  /// Stop before an edge collapse whose quadric error exceeds this; in the unit of the positions.
  double quadric_error = std::numeric_limits<double>::infinity();
};

struct Simplification {
  std::vector<Triangle> triangles;  ///< over the vertices of the mesh that was given
  /// How far the two surfaces are apart, in the unit of the positions: a quarter more than the
  /// largest distance from each vertex that is gone to the new surface and from four points of
  /// each new triangle to the old one; no less than what the quadrics say.
  double error = 0.0;
  /// It is a manifold wherever the mesh is one. False: no way was found that keeps it one.
  bool is_sound = true;
};

/// At most as many triangles as the limits say, where that is possible; of a closed surface no
/// fewer than four and of a sheet one, so that it does not vanish. The vertices `locked`
/// (ascending) and the edges between them stay, and no new edge joins two of them. Rims, of edges
/// of one triangle, become simpler along themselves. The result depends on the input alone. About
/// 200 bytes per triangle while it works.
Simplification simplify_between(std::span<const Vec3> positions,
                                std::span<const Triangle> triangles,
                                std::span<const std::uint32_t> locked,
                                const SimplifyLimits& limits);

/// As few triangles as some attempts find whose Simplification::error is at most `error`; all of
/// them where no attempt holds that.
Simplification simplify_within(std::span<const Vec3> positions, std::span<const Triangle> triangles,
                               std::span<const std::uint32_t> locked, double error);

}  // namespace orbweave
