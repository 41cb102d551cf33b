// Which boundary loops are holes, and why the others stay open.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/holes/loops/piece.h"
#include "engine/holes/problem/boundary_loop.h"
#include "io/open_reason.h"
#include "io/surface_options.h"

namespace orbweave {

/// Components of fewer triangles are removed from a mesh whose largest one has so many.
std::uint64_t least_triangles(const FillOptions& options, std::uint64_t largest);

/// The verdict on a loop.
struct HoleChoice {
  OpenReason open = OpenReason::kNone;  ///< kNone: to be filled
  std::string reason;                   ///< the same with numbers; empty: to be filled
  bool opposes_normals = false;         ///< certainly the border of a piece
};

/// Whether it follows from the scan how wide a hole of an open scene may be.
bool limits_widths(const FillOptions& options);

/// Per loop, whether it is the outer border of a sheet.
std::vector<std::uint8_t> outer_borders(std::span<const BoundaryLoop> loops,
                                        std::span<const Piece> pieces);

/// What is to become of each loop.
/// The loops' component labels are indices of `pieces`.
///
/// Outer borders (FillOptions::keep_outer_border) are loops whose area vector opposes the normals
/// along them; a loop that does neither (the end of a tube, the rim of a hemisphere) counts as
/// one where its diameter is at least half of that of its piece.
std::vector<HoleChoice> choose_holes(std::span<const BoundaryLoop> loops,
                                     std::span<const Piece> pieces, const FillOptions& options);

}  // namespace orbweave
