// Islands: pieces of the surface that lie in a hole of another piece. A patch that took no notice
// of them would run through or over them; one that is bounded by them as well joins them to the
// rest.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/problem/boundary_loop.h"
#include "io/stop_token.h"

namespace orbweave {

/// Per loop the loops of islands in it, ascending. `is_hole[l]`: loop l is to be filled;
/// `may_be_island[l]`: it is the outer border of a piece. A border counts where it faces the same
/// way as the hole and lies, seen along the hole's normal, inside the loop and close to its plane.
/// The smallest such hole has it. `vertices`: those of the loops, ascending. `stop`, which may be
/// null, is looked at several times a second.
std::vector<std::vector<std::uint32_t>> find_islands(std::span<const BoundaryLoop> loops,
                                                     std::span<const std::uint8_t> is_hole,
                                                     std::span<const std::uint8_t> may_be_island,
                                                     std::span<const BoundaryVertex> vertices,
                                                     const StopToken* stop = nullptr);

/// The hole's loop with those of its islands spliced in by bridges: edges that the loop runs along
/// both ways. Each island is joined where it is nearest to what is joined already. O(n^2) for n
/// corners; `stop` as above.
BoundaryLoop join_islands(const BoundaryLoop& hole, std::span<const BoundaryLoop> loops,
                          std::span<const std::uint32_t> islands,
                          std::span<const BoundaryVertex> vertices,
                          const StopToken* stop = nullptr);

}  // namespace orbweave
