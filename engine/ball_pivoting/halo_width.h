// The margin around a chunk that ball pivoting needs.
#pragma once

#include <span>
#include <vector>

namespace orbweave {

/// Margin that a chunk needs around its owned points for their triangles to be those of the
/// uncut cloud. docs/dev/halo.md derives it.
double halo_width(std::span<const double> ball_radii);

/// Upper bound of the length of an edge of a triangle. Both ends touch one ball as the perturbation
/// moves them; in the input they may lie a little farther apart than two radii.
double longest_edge(std::span<const double> ball_radii);

/// Per level, how far from the owned points a triangle of the level can still matter to them:
/// points that are farther away need no walk. docs/dev/halo.md.
std::vector<double> walk_reaches(std::span<const double> ball_radii);

}  // namespace orbweave
