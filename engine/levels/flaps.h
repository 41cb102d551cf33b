// Pairs of triangles that an edge collapse leaves behind.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// Without flaps: two triangles of the same three vertices, back to back. The collapse of an edge
/// leaves one where its ends had a third neighbour in common with a vertex between the three. The
/// rest of the surface is then as sound as it was before. `unsound`: what unsound_vertices() finds
/// in the triangles. Triangles with two of the `locked` vertices stay. Both ascend; order is kept.
std::vector<Triangle> without_flaps(std::span<const Triangle> triangles,
                                    std::span<const std::uint32_t> unsound,
                                    std::span<const std::uint32_t> locked);

}  // namespace orbweave
