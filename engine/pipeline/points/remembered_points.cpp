#include "engine/pipeline/points/remembered_points.h"

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <utility>

namespace orbweave {
namespace {

std::size_t held_by(const PointCloud& points) {
  return (points.positions.capacity() + points.normals.capacity()) * sizeof(Vec3) +
         points.attributes.capacity();
}

class RememberedSource final : public PointSource {
 public:
  RememberedSource(const PointSchema& schema, std::deque<RememberedPoints::Batch> batches)
      : schema_(schema), batches_(std::move(batches)) {}

  const PointSchema& schema() const override { return schema_; }
  std::optional<std::uint64_t> declared_points() const override { return std::nullopt; }
  std::uint64_t bytes_read() const override { return 0; }
  std::uint64_t bytes_total() const override { return 0; }
  ScanNumber scan() const override { return scan_; }

  bool read(PointCloud& batch, std::size_t capacity) override {
    batch.clear();
    if (batches_.empty()) return false;
    if (batches_.front().points.size() > capacity)
      throw std::logic_error("a remembered batch is larger than those asked for");
    batch = std::move(batches_.front().points);
    scan_ = batches_.front().scan;
    batches_.pop_front();
    return true;
  }

 private:
  PointSchema schema_;
  std::deque<RememberedPoints::Batch> batches_;
  ScanNumber scan_;
};

}  // namespace

void RememberedPoints::take(PointCloud& batch, ScanNumber scan) {
  if (!are_all()) return;
  bytes_ += held_by(batch);
  if (bytes_ > most_bytes_) {
    most_bytes_ = 0;
    batches_.clear();
    return;
  }
  batches_.push_back({std::exchange(batch, PointCloud{}), scan});
}

std::unique_ptr<PointSource> RememberedPoints::source(const PointSchema& schema) {
  return std::make_unique<RememberedSource>(schema, std::exchange(batches_, {}));
}

}  // namespace orbweave
