// Sites of the implicit function around a hole.
// Carr, Beatson, Cherrie, Mitchell, Fright, McCallum, Evans: Reconstruction and Representation of
// 3D Objects with Radial Basis Functions, SIGGRAPH 2001, section 2 (off-surface points).
#pragma once

#include <cstdint>
#include <vector>

#include "engine/holes/patch/rim.h"
#include "engine/holes/problem/hole.h"
#include "engine/holes/rbf/rbf.h"

namespace orbweave {

/// At most `most` vertices of the problem that have a normal, the rim's first, ascending by their
/// distance from it; their own distances grow with it where all would be too many.
std::vector<std::uint32_t> choose_sites(const HoleProblem& problem, const Rim& rim,
                                        std::uint32_t most);

/// Signed distances for an interpolant in space, relative to the rim's centre: 0 at the sites, and
/// for each one more point along its normal, to the outside for one, to the inside for the next; a
/// spacing away, or nearer where another gathered vertex would be nearer to it than the site.
struct SignedDistances {
  std::vector<RbfSite> points;  ///< first the sites
  std::vector<double> values;
};
SignedDistances signed_distances(const HoleProblem& problem, const Rim& rim,
                                 const std::vector<std::uint32_t>& sites);

}  // namespace orbweave
