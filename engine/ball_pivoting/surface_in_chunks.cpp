#include "engine/ball_pivoting/surface_in_chunks.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace orbweave {
namespace {

/// A cloud in canonical order, and which of its points lie in which chunk.
class ChunkedCloud {
 public:
  ChunkedCloud(std::span<const Vec3> positions, std::span<const Vec3> normals, Octree octree)
      : positions_(positions), normals_(normals), octree_(std::move(octree)) {
    for (const Chunk& chunk : octree_.chunks()) begin_.push_back(first_from(chunk.code_begin));
    begin_.push_back(positions.size());
  }

  std::size_t chunks() const { return octree_.chunks().size(); }

  /// Whether halos of that width leave chunks most of their size.
  bool has_room_for(double halo) const {
    constexpr double kLeastHalos = 8.0;
    return std::ranges::all_of(octree_.chunks(), [&](const Chunk& chunk) {
      return chunk.box.largest_extent() >= kLeastHalos * halo;
    });
  }

  std::vector<Triangle> triangles_of(ChunkId chunk, double halo,
                                     const BallPivotingOptions& options) const {
    const Reached reached = reached_by(chunk, halo);
    std::vector<Triangle> triangles =
        ball_pivoting(reached.positions, reached.normals, reached.owned, options).triangles;
    for (Triangle& t : triangles)
      for (std::uint32_t& corner : t) corner = reached.places[corner];
    return triangles;
  }

 private:
  /// A chunk's points and those around it, in canonical order.
  struct Reached {
    std::vector<Vec3> positions, normals;
    std::vector<std::uint8_t> owned;
    std::vector<std::uint32_t> places;  ///< in the whole cloud
  };

  std::size_t first_from(std::uint64_t code) const {
    const auto at = std::partition_point(positions_.begin(), positions_.end(), [&](const Vec3& p) {
      return octree_.frame().code(p) < code;
    });
    return static_cast<std::size_t>(at - positions_.begin());
  }

  Reached reached_by(ChunkId chunk, double halo) const {
    const Box reach = octree_.chunks()[chunk].box.grown(halo);
    std::vector<ChunkId> sources = octree_.neighbors(chunk, halo);
    sources.push_back(chunk);
    std::sort(sources.begin(), sources.end());
    Reached reached;
    for (const ChunkId source : sources) {
      for (std::size_t i = begin_[source]; i < begin_[source + 1]; ++i) {
        if (source != chunk && !reach.contains(positions_[i])) continue;
        reached.positions.push_back(positions_[i]);
        reached.normals.push_back(normals_[i]);
        reached.owned.push_back(source == chunk ? 1 : 0);
        reached.places.push_back(static_cast<std::uint32_t>(i));
      }
    }
    return reached;
  }

  std::span<const Vec3> positions_, normals_;
  Octree octree_;
  std::vector<std::size_t> begin_;  // of each chunk's points, and the number of points
};

}  // namespace

std::vector<Triangle> triangles_in_chunks(std::span<const Vec3> positions,
                                          std::span<const Vec3> normals,
                                          const BallPivotingOptions& options, Octree octree) {
  const auto at_once = [&] { return ball_pivoting(positions, normals, {}, options).triangles; };
  if (octree.chunks().size() <= 1) return at_once();
  const ChunkedCloud cloud(positions, normals, std::move(octree));
  const double halo = halo_width(options.ball_radii);
  if (!cloud.has_room_for(halo)) return at_once();
  std::vector<std::vector<Triangle>> of_chunks(cloud.chunks());
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, of_chunks.size(), 1),
      [&](const auto& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
          tbb::this_task_arena::isolate(
              [&] { of_chunks[i] = cloud.triangles_of(static_cast<ChunkId>(i), halo, options); });
      },
      tbb::simple_partitioner());
  // A chunk's triangles have their smallest corners there, so one list after another is sorted.
  std::size_t count = 0;
  for (const std::vector<Triangle>& triangles : of_chunks) count += triangles.size();
  std::vector<Triangle> all;
  all.reserve(count);
  for (std::vector<Triangle>& triangles : of_chunks) {
    all.insert(all.end(), triangles.begin(), triangles.end());
    triangles = {};
  }
  return all;
}

}  // namespace orbweave
