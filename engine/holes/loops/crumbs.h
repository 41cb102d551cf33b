// Loose sheets beside a closed object: what mixed pixels, reflections and inner walls leave.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/loops/piece.h"
#include "engine/holes/problem/boundary_loop.h"

namespace orbweave {

/// Per piece, whether it is a crumb of a closed object: the largest piece is no open scene
/// (pieces_of_scenes), and this one has less than a 500th of its triangles and no more than 1,000,
/// lies in its box or within a few spacings of it, and has a border of its own. An object that is
/// seen from all around has no loose sheets, and each would keep it from being watertight. Open
/// scenes keep theirs: leaves, wires and cars are such sheets.
/// `is_border`: per loop, whether it is an outer border. The loops' components are indices of
/// `pieces`. Pieces that touch in a vertex share a loop there: they are judged as one.
std::vector<std::uint8_t> find_crumbs(std::span<const BoundaryLoop> loops,
                                      std::span<const Piece> pieces,
                                      std::span<const std::uint8_t> is_border);

/// Takes pieces, and all that touch them, out of the crumbs.
void keep_pieces(std::span<const BoundaryLoop> loops, std::span<const std::uint64_t> kept,
                 std::span<std::uint8_t> crumbs);

}  // namespace orbweave
