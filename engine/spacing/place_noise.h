// The noise of a scanned surface about itself, at one place.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry/local_surface.h"
#include "engine/geometry/point_tree.h"
#include "io/vec3.h"

namespace orbweave {

struct PlaceNoise {
  double spacing = 0.0;  ///< mean distance to the six nearest neighbours
  double noise = 0.0;    ///< root mean square off the local surface, without detail of the shape
  double radius = 0.0;   ///< of the neighbourhood that was measured
  /// False: the points fill the neighbourhood like leaves of a tree, and there is no surface.
  bool is_layer = true;
  double nearest = 0.0;  ///< distance to the nearest neighbour
  /// Mean fourth power of the distances from the local surface over the squared mean square: 1 for
  /// two sharp layers, 1.8 for an even slab, 3 for noise.
  double kurtosis = 3.0;
};

/// How far a measurement looks.
struct PlaceLimits {
  double reach = 0.0;              ///< neighbourhoods are no wider; world units
  std::size_t most_points = 1536;  ///< nor have they more points
};

/// Fits quadrics to the 12, 24, 48, ... nearest points until a neighbourhood is clearly wider than
/// its points deviate (docs/cleaning.md). One for each thread.
class NoiseMeter {
 public:
  /// Replaces the neighbours by the place itself and at least so many others, nearest first; fewer
  /// where there are no more.
  using Find = std::function<void(std::size_t count, std::vector<Neighbor>& found)>;

  /// At place `p` of `points`. Nothing where the limits leave fewer than two neighbourhoods.
  std::optional<PlaceNoise> at(Vec3 p, std::span<const Vec3> points, PlaceLimits limits,
                               const Find& find);

 private:
  std::vector<Neighbor> found_;
  std::vector<SurfaceSample> samples_;
};

/// Layers of which the noise is more than that multiple of the spacing are too thick for an empty
/// ball to roll over them.
inline constexpr double kThickPerSpacing = 0.09;

}  // namespace orbweave
