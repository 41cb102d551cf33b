// Flaps at the rims of holes: triangles onto whose backs every patch would fold.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/problem/boundary_loop.h"
#include "engine/holes/problem/surface.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// What is taken out of a mesh at its boundary.
struct RimFlaps {
  std::vector<Triangle64> triangles;  ///< sorted
  std::vector<std::uint64_t> freed;   ///< vertices that only they used, ascending
  double area = 0.0;                  ///< of the triangles
};

/// Finds the flaps of small loops and takes them off the boundary. Where even the triangulation of
/// a loop's corners that bends least turns by more than 120 degrees at edges of the rim, and so
/// over more than a tenth of its area, the surface ends there in triangles that stick out over
/// another layer of it: at the foot of a wall, at eaves, in foliage. The triangles behind these
/// edges are flaps, up to three deep, as far as what is folded without them is at most half of what
/// was. The sheet hangs together as before, and no loop vanishes or falls apart: a flap goes that
/// has one edge on the boundary and its third corner off it, or two edges that follow each other.
/// `loops`: of the whole boundary, in canonical order; those that are flagged in `is_wanted` are
/// looked at, up to 16 edges, unless their normals agree (BoundaryLoop::agreement() above 0.8) or
/// they touch themselves. `fans` and `vertices`: of the whole boundary. All are brought up to date;
/// the fans come in another order. A pure function of these and the surface, which still has the
/// triangles afterwards. `stop` may be null.
RimFlaps take_rim_flaps(std::span<const std::uint8_t> is_wanted, const Surface& surface,
                        std::vector<BoundaryLoop>& loops, std::vector<OpenFan>& fans,
                        std::vector<BoundaryVertex>& vertices, const StopToken* stop = nullptr);

}  // namespace orbweave
