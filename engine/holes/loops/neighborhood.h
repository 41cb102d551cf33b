// The surroundings of a hole: what the patch is shaped after.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/problem/boundary_loop.h"
#include "engine/holes/problem/hole.h"
#include "engine/holes/problem/surface.h"

namespace orbweave {

struct NeighborhoodOptions {
  /// Vertices within this many times the loop's radius of its centre; two rings at least.
  double radius_factor = 2.0;
  /// The ring that exceeds this many vertices is the last one.
  std::uint32_t max_vertices = 20'000;
  /// Rings beyond the rim at most; 0: no limit.
  std::uint32_t max_rings = 0;
  /// Whether all triangles at the vertices of the last ring are wanted where there is such a limit;
  /// without, those at the rings before, and the last ring's normals are not whole.
  bool whole_fans = true;
};

/// A problem in the numbers of the gathered vertices, and which vertices those are. The problem
/// asks the surface for the values of these vertices: both must outlive it. May be moved, not
/// copied.
struct GatheredHole {
  HoleProblem problem;
  std::vector<std::uint64_t> vertices;  ///< ascending: vertex i of the problem is vertices[i]
};

/// Walks over the triangles from the rim outward, ring by ring, so that another sheet close by is
/// never taken for this one. What is gathered does not depend on how the mesh is stored.
/// `apart`: as HoleProblem::apart, in the mesh's numbers; groups may have any numbers.
GatheredHole gather_hole(const Surface& surface, const BoundaryLoop& loop,
                         std::span<const std::array<std::uint64_t, 2>> apart,
                         const NeighborhoodOptions& options);

}  // namespace orbweave
