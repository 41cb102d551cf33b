// Noise and spacing at places all over a cloud, one in each cube of a lattice.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

/// What was measured at a place.
struct NoisePlace {
  Vec3 position;
  double spacing = 0.0;  ///< between neighbouring points; 0: too few points to measure anything
  double noise = 0.0;    ///< off the local surface; negative: there is no surface
};

struct NoisePlaceOptions {
  double cell = 0.0;               ///< side of the cubes, world units, positive
  double reach = 0.0;              ///< neighbourhoods are no wider; world units
  std::size_t most_points = 1536;  ///< nor have they more points
  const StopToken* stop = nullptr;
};

/// Margin that a chunk needs around its points.
double noise_halo(const NoisePlaceOptions& options);

/// Places of points [begin, end): in every cube of the lattice, which is anchored at the world's
/// zero, the point whose hash comes first. Positions must be distinct, finite and in canonical
/// order, and reach as far as the halo; the places of all chunks together then are those of the
/// uncut cloud, to the last bit. Runs on the calling TBB arena.
std::vector<NoisePlace> measure_noise_places(std::span<const Vec3> positions, std::uint32_t begin,
                                             std::uint32_t end, const NoisePlaceOptions& options);

}  // namespace orbweave
