#include "engine/pipeline/surface/chunk_with_halo.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <span>
#include <vector>

#include "io/first_touch.h"
#include "io/store/chunk_points.h"

namespace orbweave {
namespace {

/// Puts a neighbour's points in their place, from `at` on; returns where they end.
std::size_t put(const PointsInBox& from, std::uint64_t first_vertex, std::size_t at,
                ChunkPoints& to) {
  const auto place = static_cast<std::ptrdiff_t>(at);
  std::copy(from.points.positions.begin(), from.points.positions.end(),
            to.positions.begin() + place);
  std::copy(from.points.normals.begin(), from.points.normals.end(), to.normals.begin() + place);
  for (const std::uint32_t row : from.rows) to.global[at++] = first_vertex + row;
  return at;
}

/// Puts the chunk's own points, read straight to their place.
std::size_t put_own(const ChunkStore& store, const Partition& partition, ChunkId chunk,
                    std::size_t at, ChunkPoints& to) {
  const std::size_t count = partition.points_in(chunk);
  load_oriented_points(store, chunk, partition.schema, std::span(to.positions).subspan(at, count),
                       std::span(to.normals).subspan(at, count), partition.stage);
  const auto first = to.global.begin() + static_cast<std::ptrdiff_t>(at);
  std::iota(first, first + static_cast<std::ptrdiff_t>(count), partition.first_vertex[chunk]);
  std::fill_n(to.owned.begin() + static_cast<std::ptrdiff_t>(at), count, std::uint8_t{1});
  to.owned_begin = static_cast<std::uint32_t>(at);
  to.owned_end = static_cast<std::uint32_t>(at + count);
  return at + count;
}

}  // namespace

ChunkPoints load_chunk_with_halo(const ChunkStore& store, const Partition& partition, ChunkId chunk,
                                 double halo, const StopToken* stop) {
  const Chunk& self = partition.octree.chunks()[chunk];
  const Box reach = self.box.grown(halo);
  std::vector<ChunkId> sources = partition.octree.neighbors(chunk, halo);
  sources.push_back(chunk);
  // Chunks in Morton order, points in canonical order within: the whole is in canonical order.
  std::sort(sources.begin(), sources.end());
  std::vector<PointsInBox> parts;
  std::size_t count = partition.points_in(chunk);
  for (const ChunkId source : sources) {
    check_stop(stop);
    parts.push_back(source == chunk ? PointsInBox{}
                                    : load_points_in_box(store, source, partition.schema, reach, {},
                                                         partition.stage));
    count += parts.back().rows.size();
  }
  ChunkPoints points;
  points.origin = partition.bounds.center();
  reserve_touched(points.positions, count);
  points.positions.resize(count);
  reserve_touched(points.normals, count);
  points.normals.resize(count);
  reserve_touched(points.global, count);
  points.global.resize(count);
  points.owned.resize(count, 0);
  std::size_t at = 0;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    at = sources[i] == chunk ? put_own(store, partition, chunk, at, points)
                             : put(parts[i], partition.first_vertex[sources[i]], at, points);
    parts[i] = {};
  }
  return points;
}

}  // namespace orbweave
