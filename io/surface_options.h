// What decides the surface of given points: normals and holes. A job and the library's front door
// (engine/reconstruct.h) take the same options.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "io/vec3.h"

namespace orbweave {

enum class NormalSource { kAuto, kFile, kEstimate };
enum class Orientation { kAuto, kScanner, kViewpoint, kUp, kPropagate, kNone };

struct NormalOptions {
  NormalSource source = NormalSource::kAuto;  ///< kAuto: the given ones, else estimated
  int neighbors = 16;                         ///< neighbours per normal, 3 to 256
  Orientation orientation = Orientation::kAuto;
  std::optional<Vec3> viewpoint;  ///< world coordinates; normals point towards it
  std::optional<Vec3> up;         ///< a direction; normals point to its side
};

enum class FillKernel { kBiharmonic, kTriharmonic };

struct FillOptions {
  bool enabled = true;
  FillKernel kernel = FillKernel::kBiharmonic;
  /// Radius of the neighbourhood that shapes a patch, in radii of the hole; at least 1.
  double neighborhood = 2.0;
  double max_diameter = std::numeric_limits<double>::infinity();   ///< world units
  double max_perimeter = std::numeric_limits<double>::infinity();  ///< world units
  std::uint64_t max_edges = 0;                                     ///< of a loop; 0: no limit
  /// Where every candidate patch intersects the surface: use the one with the fewest intersections
  /// (true), or leave the hole open (false).
  bool allow_intersections = true;
  bool keep_outer_border = true;    ///< the outer border of an open sheet stays open
  std::uint64_t min_triangles = 0;  ///< components of fewer triangles are removed; 0: none
};

}  // namespace orbweave
