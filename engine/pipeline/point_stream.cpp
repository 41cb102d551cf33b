#include "engine/pipeline/point_stream.h"

#include <oneapi/tbb/concurrent_queue.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace orbweave {
namespace {

/// Why a point is of no use; null when it is of use.
const char* objection(const PointCloud& points, std::size_t i) {
  if (!is_finite(points.positions[i])) return "coordinate not finite";
  if (points.normals.empty()) return nullptr;
  if (!is_finite(points.normals[i])) return "normal not finite";
  if (!(squared_norm(points.normals[i]) > 0.0)) return "zero normal";
  return nullptr;
}

void move_point(PointCloud& points, std::size_t from, std::size_t to) {
  points.positions[to] = points.positions[from];
  if (!points.normals.empty()) points.normals[to] = points.normals[from];
  const std::size_t bytes = points.schema.attribute_bytes();
  if (bytes != 0) {
    std::memcpy(points.attributes.data() + to * bytes, points.attributes.data() + from * bytes,
                bytes);
  }
}

}  // namespace

DroppedPoints drop_unusable(PointCloud& points) {
  DroppedPoints dropped;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (const char* reason = objection(points, i)) {
      ++dropped[reason];
      continue;
    }
    if (kept != i) move_point(points, i, kept);
    ++kept;
  }
  points.positions.resize(kept);
  if (!points.normals.empty()) points.normals.resize(kept);
  points.attributes.resize(kept * points.schema.attribute_bytes());
  return dropped;
}

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
    return batch;
  };
  const auto clean = [&](StreamBatch* batch) {
    batch->points_read = batch->points.size();
    batch->dropped = drop_unusable(batch->points);
    if (prepare) prepare(*batch);
    return batch;
  };
  const auto use = [&](StreamBatch* batch) {
    consume(*batch);
    idle.push(batch);
  };
  tbb::task_arena arena(options.threads);
  arena.execute([&] {
    tbb::parallel_pipeline(
        in_flight,
        tbb::make_filter<void, StreamBatch*>(tbb::filter_mode::serial_in_order, read) &
            tbb::make_filter<StreamBatch*, StreamBatch*>(tbb::filter_mode::parallel, clean) &
            tbb::make_filter<StreamBatch*, void>(tbb::filter_mode::serial_in_order, use));
  });
}

}  // namespace orbweave
