// How much of the work on chunks is that on their halos.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/vec3.h"
#include "partition/octree.h"
#include "partition/point_counts.h"

namespace orbweave {

/// Points of a cube of the cloud, as if all were in its middle.
struct CrowdedPlace {
  Vec3 middle;
  std::uint64_t points = 0;
};

/// The cubes, a 256th of the root cube wide, that hold points.
std::vector<CrowdedPlace> crowded_places(const PointCounts& grid, const RootCube& root);

/// How many points the chunks have with those within `halo` of them, over the points of the cloud.
double halo_work(std::span<const CrowdedPlace> places, const Octree& octree, double halo);

/// `fine` with its chunks put together, twice as large again and again, until the halos are no more
/// than the chunks themselves, or until a chunk would have more than `most_points`. On an even
/// surface `chunk_points` leads there at once; where points crowd, each chunk near them has them in
/// its halo.
Octree without_needless_halos(std::span<const CrowdedPlace> places, const Octree& fine, double halo,
                              std::uint64_t chunk_points, std::uint64_t most_points);

}  // namespace orbweave
