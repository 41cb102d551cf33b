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

/// The points of every chunk with those within `halo` of it.
std::vector<std::uint64_t> points_in_reach(std::span<const CrowdedPlace> places,
                                           const Octree& octree, double halo);

/// How many points the chunks have with those within `halo` of them, over the points of the cloud.
double halo_work(std::span<const CrowdedPlace> places, const Octree& octree, double halo);

/// What the memory has room for where a chunk is worked on alone.
struct ChunkRoom {
  std::uint64_t points = 0;     ///< of the chunk
  std::uint64_t with_halo = 0;  ///< and those of its halo
};

/// `fine` with its chunks put together, twice as large again and again, until the halos are no more
/// than the chunks themselves, or until there is no room for a chunk. On an even surface
/// `chunk_points` leads there at once; where points crowd, each chunk near them has them in its
/// halo, and a larger chunk hardly has more of them.
Octree without_needless_halos(std::span<const CrowdedPlace> places, const Octree& fine, double halo,
                              std::uint64_t chunk_points, const ChunkRoom& room);

}  // namespace orbweave
