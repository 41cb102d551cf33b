// A pass over the input: batches are read one after the other, cleaned and prepared in parallel,
// and consumed in the order read.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "io/chunk_store.h"
#include "io/point_source.h"
#include "partition/executor.h"

namespace orbweave {

/// Removes points with a coordinate that is not finite and, where there are normals, points whose
/// normal is not finite or zero; keeps the order of the rest.
DroppedPoints drop_unusable(PointCloud& points);

struct StreamBatch {
  PointCloud points;  ///< usable ones
  DroppedPoints dropped;
  std::uint64_t points_read = 0;
  std::vector<ChunkId> chunks;  ///< for `prepare` to fill, if it likes
};

struct StreamOptions {
  int threads = 1;
  std::size_t batch_points = std::size_t{1} << 16;
  const StopToken* stop = nullptr;
};

/// `prepare` runs in parallel after the cleaning (may be empty), `consume` in order.
void stream_points(PointSource& source, const StreamOptions& options,
                   const std::function<void(StreamBatch&)>& prepare,
                   const std::function<void(StreamBatch&)>& consume);

}  // namespace orbweave
