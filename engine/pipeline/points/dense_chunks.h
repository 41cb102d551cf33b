// Chunks that hold more points than memory has room for: what the count grid was too coarse for is
// counted again and cut further; what cannot be cut, because its points are all in one place, is
// merged piece by piece.
#pragma once

#include <utility>

#include "engine/pipeline/points/cloud_input.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "partition/binning.h"

namespace orbweave {

/// Cuts the chunks that are much too full. Reads the input once more where there are any, rarely
/// twice. `cloud.octree` ends the same for any order of the points.
void split_dense_chunks(const RunControl& control, const CloudInput& input, CountedCloud& cloud);

/// Most points of a chunk that are sorted together; where there are more, they are mostly
/// duplicates.
std::uint64_t most_sorted_points(const MemoryPlan& plan, const PointSchema& schema);

/// The bins [first, second) that lie in a chunk of the final partition.
std::pair<ChunkId, ChunkId> bins_in(const Octree& bins, const Chunk& chunk);

/// The points of a chunk of the final partition, from the bins that lie in it, in canonical order
/// and without duplicates. Holds little more than `most_sorted_points` at one time, or twice the
/// distinct points where these are more.
struct SortedChunk {
  PointCloud points;
  std::uint64_t merged = 0;
};
SortedChunk take_sorted(BinSource& source, const Octree& bins, const Chunk& chunk,
                        std::uint64_t most_points, const StopToken* stop = nullptr);

}  // namespace orbweave
