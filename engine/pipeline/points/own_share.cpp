#include "engine/pipeline/points/own_share.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace orbweave {
namespace {

class NoPoints final : public PointSource {
 public:
  explicit NoPoints(const PointSource& like)
      : schema_(like.schema()),
        coordinate_system_(like.coordinate_system()),
        meters_per_unit_(like.meters_per_unit()) {}
  const PointSchema& schema() const override { return schema_; }
  std::optional<std::uint64_t> declared_points() const override { return 0; }
  bool read(PointCloud& batch, std::size_t /*capacity*/) override {
    batch.clear();
    batch.schema = schema_;
    return false;
  }
  std::uint64_t bytes_read() const override { return 0; }
  std::uint64_t bytes_total() const override { return 0; }
  std::string coordinate_system() const override { return coordinate_system_; }
  std::optional<Vec3> meters_per_unit() const override { return meters_per_unit_; }

 private:
  PointSchema schema_;
  std::string coordinate_system_;
  std::optional<Vec3> meters_per_unit_;
};

/// A source without its first points.
class RestOfPoints final : public PointSource {
 public:
  RestOfPoints(std::unique_ptr<PointSource> source, std::uint64_t skipped)
      : source_(std::move(source)), to_skip_(skipped) {}
  const PointSchema& schema() const override { return source_->schema(); }
  std::optional<std::uint64_t> declared_points() const override { return std::nullopt; }
  bool read(PointCloud& batch, std::size_t capacity) override {
    while (source_->read(batch, capacity)) {
      const std::uint64_t skipped = std::min<std::uint64_t>(to_skip_, batch.size());
      to_skip_ -= skipped;
      if (skipped == batch.size()) continue;
      if (skipped > 0) batch = without_first(batch, skipped);
      return true;
    }
    return false;
  }
  std::uint64_t bytes_read() const override { return source_->bytes_read(); }
  std::uint64_t bytes_total() const override { return source_->bytes_total(); }
  std::optional<ScannerPlace> scanner() const override { return source_->scanner(); }
  ScanNumber scan() const override { return source_->scan(); }
  DroppedPoints left_out() const override { return source_->left_out(); }
  std::string coordinate_system() const override { return source_->coordinate_system(); }
  std::optional<Vec3> meters_per_unit() const override { return source_->meters_per_unit(); }

 private:
  static PointCloud without_first(const PointCloud& batch, std::uint64_t count) {
    PointCloud rest;
    rest.schema = batch.schema;
    for (std::uint64_t i = count; i < batch.size(); ++i) rest.append(batch, i);
    return rest;
  }

  std::unique_ptr<PointSource> source_;
  std::uint64_t to_skip_;
};

}  // namespace

std::unique_ptr<PointSource> own_share(std::unique_ptr<PointSource> source,
                                       const Communicator& communicator, std::uint64_t read_before,
                                       bool rows_are_points) {
  const bool leaps = read_before > 0 && rows_are_points && source->has_row_access();
  const std::uint64_t leap = leaps ? read_before : 0;
  if (communicator.size() > 1 || leaps) {
    const auto rows = source->declared_points();
    const auto size = static_cast<std::uint64_t>(communicator.size());
    const auto rank = static_cast<std::uint64_t>(communicator.rank());
    // Whole multiples first: the product of all rows and a rank might overflow.
    const auto begin_of = [&](std::uint64_t r) {
      return *rows / size * r + *rows % size * r / size;
    };
    const auto restrict = [&] {
      const std::uint64_t share = begin_of(rank + 1) - begin_of(rank);
      return source->restrict_rows(begin_of(rank) + leap, share - std::min(leap, share));
    };
    const bool shared = rows.has_value()&& restrict();
    if (leaps && shared) return source;
    if (!shared && !communicator.is_root()) return std::make_unique<NoPoints>(*source);
  }
  if (read_before == 0) return source;
  return std::make_unique<RestOfPoints>(std::move(source), read_before);
}

}  // namespace orbweave
