// How far levels of detail are from the mesh, measured at samples.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/levels/level_maker.h"

namespace orbweave {

/// Of all nodes of one height together.
struct LevelDistance {
  /// The largest distance found, world units: from vertices of the mesh to the node above them, and
  /// from the middles of the nodes' triangles to the mesh.
  double distance = 0.0;
  /// Root of the mean squared distance from vertices of the mesh.
  double mean_distance = 0.0;
  bool has_colors = false;
  /// Root of the mean squared difference between the colour of a vertex of the mesh and that of the
  /// level at the nearest point, over the three channels; 1: all of a channel's range.
  double color_error = 0.0;
  std::uint64_t samples = 0;  ///< of both kinds
};

/// Of each height, the leaves first, whose distances are 0. At most some 260,000 vertices of the
/// mesh are measured, for each height, and some 65,000 triangles of it: every so many by their
/// numbers, so that the result does not depend on threads. Takes some 40 megabytes, and for each
/// thread the meshes of a node and a leaf. Precondition: all nodes were made.
std::vector<LevelDistance> measure_levels(const LevelMaker& maker, const StopToken& stop);

}  // namespace orbweave
