// One loop of a stitched mesh from what is around it to its patch, in the mesh's own numbers.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/holes/boundary_loop.h"
#include "engine/holes/hole.h"
#include "engine/holes/surface.h"
#include "io/job.h"
#include "io/report.h"

namespace orbweave {

/// Vertex numbers of patch triangles from here on are new vertices of the patch.
inline constexpr std::uint64_t kNewVertex = std::uint64_t{1} << 63;

struct LoopPatch {
  std::vector<Vec3> positions;  ///< new vertices
  std::vector<Vec3> normals;
  std::vector<double> values;  ///< new vertices x channels
  std::vector<Triangle64> triangles;
  HoleFacts facts;  ///< all but id, first_vertex and chunks
};

/// For every loop the pairs of its vertices that lie together on another loop: no patch may join
/// them, since another one may.
std::vector<std::vector<std::array<std::uint64_t, 2>>> shared_pairs(
    std::span<const BoundaryLoop> loops);

/// What is known of a loop before it is filled.
HoleFacts facts_of_loop(const BoundaryLoop& loop);

/// Gathers the neighbourhood and fills the hole. The result depends on the mesh alone.
LoopPatch fill_loop(const Surface& surface, const BoundaryLoop& loop,
                    std::span<const std::array<std::uint64_t, 2>> taken,
                    const FillOptions& options);

}  // namespace orbweave
