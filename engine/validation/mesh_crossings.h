// How often a mesh crosses itself.
#pragma once

#include <cstdint>

#include "io/triangle_mesh.h"

namespace orbweave {

/// Pairs of triangles that intersect beyond the vertices and the edge that they share; vertices at
/// one place count as one. Decided exactly. O(n log n) where few boxes overlap.
std::uint64_t count_crossing_pairs(const TriangleMesh& mesh);

}  // namespace orbweave
