// Which holes are filled, and how.
#pragma once

#include <cstdint>
#include <limits>

#include "engine/holes/problem/hole.h"

namespace orbweave {

struct HoleOptions {
  RbfKernel kernel = RbfKernel::kBiharmonic;
  /// Points within this many times the radius of a hole of its centre shape the patch; at least 1.
  double neighborhood = 2.0;
  double max_diameter = std::numeric_limits<double>::infinity();   ///< world units
  double max_perimeter = std::numeric_limits<double>::infinity();  ///< world units
  std::uint64_t max_edges = 0;                                     ///< of a loop; 0: no limit
  /// Where every candidate patch intersects the surface: the one with the fewest intersections is
  /// used (true), or the hole stays open (false).
  bool allow_intersections = true;
  bool keep_outer_border = true;    ///< the outer border of an open sheet stays open
  std::uint64_t min_triangles = 0;  ///< components of fewer triangles are removed; 0: none
};

}  // namespace orbweave
