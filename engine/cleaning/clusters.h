// Small groups of points that lie apart from all others: drops of rain, birds, trails of pixels
// between two surfaces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

struct ClusterOptions {
  std::uint64_t points = 0;         ///< a cluster of fewer is small
  double gap = 0.0;                 ///< side of the cubes that hang together; world units, positive
  const StopToken* stop = nullptr;  ///< looked at every few thousand points; may be null
};

/// Margin that a chunk needs around its points.
double cluster_halo(const ClusterOptions& options);

/// 1 for each of positions [begin, end) that belongs to a small cluster. Points in one cube of a
/// lattice, and in cubes that touch, belong together; the lattice is anchored at the world's zero.
/// A cluster that is longer than three cubes along an axis is not small, however few its points
/// are: a wire stays. Positions must be finite and reach as far as the halo; the result then does
/// not depend on what else they hold, nor on their order. O(n log n).
std::vector<std::uint8_t> find_clusters(std::span<const Vec3> positions, std::uint32_t begin,
                                        std::uint32_t end, const ClusterOptions& options);

}  // namespace orbweave
