#include "engine/pipeline/points/dense_chunks.h"

#include <algorithm>
#include <span>
#include <utility>

#include "partition/canonical_order.h"

namespace orbweave {
namespace {

/// A chunk may be fuller than planned by that factor: counting again takes a pass over the input.
constexpr std::uint64_t kTooFull = 2;

std::vector<ChunkId> dense_chunks(const CountedCloud& cloud) {
  std::vector<ChunkId> dense;
  const std::vector<Chunk>& chunks = cloud.octree.chunks();
  for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk) {
    if (chunks[chunk].points > kTooFull * cloud.memory.chunk_points &&
        chunks[chunk].depth < kMortonDepth)
      dense.push_back(chunk);
  }
  return dense;
}

/// Counts the points of these chunks alone: the same memory makes finer cells for fewer of them.
CountGrid count_again(const RunControl& control, const CloudInput& input, const CountedCloud& cloud,
                      std::span<const ChunkId> dense) {
  const Octree& octree = cloud.octree;
  const auto in_dense = [&](Vec3 p) {
    return std::binary_search(dense.begin(), dense.end(), octree.chunk_of(p));
  };
  CountGrid grid(CountGrid::kUsualLimitBytes, octree.root().cell(kMortonDepth));
  const auto source = input.open(nullptr);
  stream_points(
      *source, {.threads = control.threads(), .stop = &control.stop, .filter = &cloud.filter},
      [&](StreamBatch& batch) {
        std::erase_if(batch.points.positions, [&](Vec3 p) { return !in_dense(p); });
      },
      [&](StreamBatch& batch) {
        grid.add(batch.points.positions);
        control.progress.add_points(batch.points_read);
      });
  grid.settle(octree.root().side);
  return grid;
}

}  // namespace

void split_dense_chunks(const RunControl& control, const CloudInput& input, CountedCloud& cloud) {
  double cell = cloud.grid.cell();
  for (;;) {
    const std::vector<ChunkId> dense = dense_chunks(cloud);
    if (dense.empty()) return;
    const CountGrid grid = count_again(control, input, cloud, dense);
    if (!(grid.cell() < cell)) return;
    cell = grid.cell();
    cloud.octree = refined(cloud.octree, dense, grid, cloud.memory.chunk_points);
  }
}

std::uint64_t most_sorted_points(const MemoryPlan& plan, const PointSchema& schema) {
  return std::max<std::uint64_t>(plan.chunk_points,
                                 plan.chunks_in_flight_bytes / 4 / MemoryCosts::sort_bytes(schema));
}

std::pair<ChunkId, ChunkId> bins_in(const Octree& bins, const Chunk& chunk) {
  const std::vector<Chunk>& fine = bins.chunks();
  const auto at = [&](std::uint64_t code) {
    const auto found =
        std::lower_bound(fine.begin(), fine.end(), code,
                         [](const Chunk& a, std::uint64_t b) { return a.code_begin < b; });
    return static_cast<ChunkId>(found - fine.begin());
  };
  return {at(chunk.code_begin), at(chunk.code_end)};
}

SortedChunk take_sorted(BinSource& source, const Octree& bins, const Chunk& chunk,
                        std::uint64_t most_points, const StopToken* stop) {
  SortedChunk sorted;
  std::uint64_t limit = most_points;
  const auto sort = [&] {
    check_stop(stop);
    sorted.merged += sort_canonically(sorted.points, bins.root());
  };
  // Room for the whole chunk at once: columns that grow are copied over and over.
  const auto append = [&](const PointCloud& part) {
    const std::uint64_t expected = std::min<std::uint64_t>(chunk.points, most_points + part.size());
    if (sorted.points.positions.capacity() < expected) sorted.points.reserve(expected);
    sorted.points.append(part);
  };
  const auto [first, last] = bins_in(bins, chunk);
  for (ChunkId bin = first; bin < last; ++bin) {
    source.take(bin, most_points, [&](PointCloud&& part) {
      check_stop(stop);
      if (sorted.points.empty())
        sorted.points = std::move(part);
      else
        append(part);
      if (sorted.points.size() < limit) return;
      sort();
      limit = std::max(most_points, 2 * sorted.points.size());
    });
  }
  sort();
  return sorted;
}

}  // namespace orbweave
