// Where a cloud is sampled too sparsely to tell its surface.
// Dey, Giesen, Detecting Undersampling in Surface Reconstruction, 2001.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/box.h"
#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave::voronoi {

/// Undersampled points that triangles of the Cocone join to each other.
struct UndersampledPlace {
  std::uint64_t points = 0;
  Box bounds;
};

struct Undersampling {
  std::vector<std::uint8_t> well_sampled;  ///< per point
  std::uint64_t points = 0;                ///< that are not
  std::vector<UndersampledPlace> places;   ///< most points first, then by their lowest corners
};

/// Points are in canonical order, no two at one place; fewer than 2^32. Boundaries of open
/// surfaces, sharp edges and noise look undersampled as well. Memory and time of a Cocone without
/// its extraction. Throws Error: bad input where the points lie in one plane, interrupted when
/// `stop` is requested.
Undersampling find_undersampling(std::span<const Vec3> points, const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
