#include "engine/pipeline/points/point_stream.h"

#include <oneapi/tbb/concurrent_queue.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <memory>
#include <span>
#include <utility>

#include "partition/allowed_threads.h"

namespace orbweave {

void stream_points(PointSource& source, const StreamOptions& options,
                   const std::function<void(StreamBatch&)>& prepare,
                   const std::function<void(StreamBatch&)>& consume) {
  const std::size_t in_flight = static_cast<std::size_t>(options.threads) + 2;
  std::vector<std::unique_ptr<StreamBatch>> batches;
  tbb::concurrent_bounded_queue<StreamBatch*> idle;
  for (std::size_t b = 0; b < in_flight; ++b) {
    batches.push_back(std::make_unique<StreamBatch>());
    idle.push(batches.back().get());
  }
  const auto read = [&](tbb::flow_control& flow) -> StreamBatch* {
    if (options.stop != nullptr) options.stop->check();
    StreamBatch* batch = nullptr;
    idle.pop(batch);
    if (!source.read(batch->points, options.batch_points)) {
      flow.stop();
      return nullptr;
    }
    batch->scan = source.scan();
    batch->scanner = source.scanner();
    return batch;
  };
  const PointFilter all;
  const auto clean = [&](StreamBatch* batch) {
    batch->points_read = batch->points.size();
    FilteredPoints selected =
        drop_unusable(batch->points, options.filter != nullptr ? *options.filter : all);
    batch->dropped = std::move(selected.dropped);
    batch->at_scan_origins = std::move(selected.at_scan_origins);
    if (prepare) prepare(*batch);
    return batch;
  };
  const auto use = [&](StreamBatch* batch) {
    consume(*batch);
    idle.push(batch);
  };
  tbb::task_arena arena(allowed_threads(options.threads));
  arena.execute([&] {
    tbb::parallel_pipeline(
        in_flight,
        tbb::make_filter<void, StreamBatch*>(tbb::filter_mode::serial_in_order, read) &
            tbb::make_filter<StreamBatch*, StreamBatch*>(tbb::filter_mode::parallel, clean) &
            tbb::make_filter<StreamBatch*, void>(tbb::filter_mode::serial_in_order, use));
  });
}

}  // namespace orbweave
