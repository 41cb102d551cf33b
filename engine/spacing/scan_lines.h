// Points on lines that lie farther apart than the points on them, as scanners of profiles leave
// them.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/spacing/sampled_neighbors.h"
#include "io/stop_token.h"

namespace orbweave {

/// What was measured at a place of a sample.
struct LinePlace {
  std::size_t place = 0;  ///< of the sample
  double along = 0.0;     ///< distance between the points of the line; 0: not on a line
  double across = 0.0;    ///< distance to the nearest line beside; 0: likewise, or there is none
  bool is_sure = true;    ///< nothing nearer lies outside the site
};

/// Some 4,000 places of a sample, and how far lines lie apart there. Empty where fewer than half of
/// the places lie on lines, or where what lies beside these is too far away to be of the same
/// surface (a thread, with strays about it). The sample has six neighbours of each place at least.
/// `stop` may be null. Runs on the calling TBB arena.
std::vector<LinePlace> find_scan_lines(const SampledNeighbors& sample,
                                       const StopToken* stop = nullptr);

/// The number of neighbours of a point that reaches the lines beside its own; 0 where there are
/// none.
std::size_t neighbors_across_lines(const std::vector<LinePlace>& places);

}  // namespace orbweave
