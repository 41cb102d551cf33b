// A pass over the input: batches are read one after the other, cleaned and prepared in parallel,
// and consumed in the order read.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/box.h"
#include "io/points/point_source.h"
#include "io/store/chunk_store.h"
#include "partition/executor.h"
#include "partition/point_filter.h"

namespace orbweave {

struct StreamBatch {
  PointCloud points;  ///< usable ones
  DroppedPoints dropped;
  std::vector<std::uint64_t> at_scan_origins;  ///< of `points`, at each origin of the filter
  std::uint64_t points_read = 0;
  ScanNumber scan;                      ///< that all points of the batch are of
  std::optional<ScannerPlace> scanner;  ///< that saw them, where the source knows it
  // For `prepare` to fill, if it likes.
  std::vector<ChunkId> chunks;
  Box bounds;
};

struct StreamOptions {
  int threads = 1;
  std::size_t batch_points = std::size_t{1} << 16;
  const StopToken* stop = nullptr;
  const PointFilter* filter = nullptr;  ///< null: the default one
};

/// `prepare` runs in parallel after the cleaning (may be empty), `consume` in order.
void stream_points(PointSource& source, const StreamOptions& options,
                   const std::function<void(StreamBatch&)>& prepare,
                   const std::function<void(StreamBatch&)>& consume);

}  // namespace orbweave
