// Which pieces of a mesh are of an object seen from all around, and which of an open scene.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/loops/piece.h"
#include "engine/holes/problem/boundary_loop.h"

namespace orbweave {

/// Per piece, whether it belongs to an open scene: one of its outer borders (`is_border`, per loop)
/// is a quarter as wide as the piece or more, or the holes at the sides of its box look inward, as
/// windows of a room do. What is missing of any other piece is a hole in a closed surface, however
/// wide.
std::vector<std::uint8_t> pieces_of_scenes(std::span<const BoundaryLoop> loops,
                                           std::span<const Piece> pieces,
                                           std::span<const std::uint8_t> is_border);

/// The width of a loop: of a circle the diameter, of a long gap the short side. World units.
double loop_width(const BoundaryLoop& loop);

/// The mean length of a loop's edges, world units.
double loop_spacing(const BoundaryLoop& loop);

}  // namespace orbweave
