// Triangles of a mesh that intersect one another, found exactly.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "io/stop_token.h"
#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

/// Two triangles by their numbers, the smaller one first.
using TrianglePair = std::array<std::uint32_t, 2>;

/// All pairs of triangles with more in common than the vertices and the edge that they share by
/// index (engine/geometry/triangle_intersection.h), ascending. Decided exactly. Copies of a vertex
/// are to be given by one index. Fast where triangles that follow one another lie close together,
/// as those of a mesh in canonical order do; about 60 bytes per triangle. Runs on the calling TBB
/// arena; the result does not depend on the number of threads. `stop` may be null.
std::vector<TrianglePair> crossing_pairs(std::span<const Vec3> positions,
                                         std::span<const Triangle> triangles,
                                         const StopToken* stop = nullptr);

/// Which pairs are looked for.
struct PairsWanted {
  /// At least one triangle of a pair has a number below it.
  std::uint32_t first_below = UINT32_MAX;
  /// By triangle: pairs of two zeros are passed over; empty: none is.
  std::span<const std::int32_t> mark = {};
};
std::vector<TrianglePair> crossing_pairs(std::span<const Vec3> positions,
                                         std::span<const Triangle> triangles,
                                         const PairsWanted& wanted, const StopToken* stop);

}  // namespace orbweave
