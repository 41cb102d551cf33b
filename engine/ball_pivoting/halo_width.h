// The margin around a chunk that ball pivoting needs.
#pragma once

#include <span>

namespace orbweave {

/// Margin that a chunk needs around its owned points for their triangles to be those of the
/// uncut cloud. docs/dev/halo.md derives it.
double halo_width(std::span<const double> ball_radii);

}  // namespace orbweave
