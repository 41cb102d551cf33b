#include "engine/synthetic/range_scans.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "engine/synthetic/portable_math.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kBlockPoints = std::uint64_t{1} << 16;

}  // namespace

/// The scans from `scan` to before `end`, in their own frames or all in the world's.
class RangeScans::Source : public PointSource {
 public:
  Source(const RangeScans& scans, std::size_t scan, std::size_t end, bool in_world);

  const PointSchema& schema() const override { return schema_; }
  std::optional<std::uint64_t> declared_points() const override { return total_; }
  bool read(PointCloud& batch, std::size_t capacity) override;
  std::uint64_t bytes_read() const override { return given_ * point_bytes(); }
  std::uint64_t bytes_total() const override { return total_ * point_bytes(); }
  std::optional<ScannerPlace> scanner() const override { return place_; }

 private:
  bool next_block();
  std::uint64_t point_bytes() const {
    return 3 * size_of(schema_.position_type) + schema_.attribute_bytes();
  }
  std::optional<ScannerPlace> place_of(const Scan& scan) const;

  const RangeScans& scans_;
  std::size_t scan_, end_;
  std::size_t row_ = 0;
  bool in_world_;
  PointSchema schema_;
  std::vector<Vec3> block_;  ///< of scan block_scan_
  std::size_t block_next_ = 0;
  std::size_t block_scan_ = 0;
  std::uint64_t given_ = 0, total_ = 0;
  std::optional<ScannerPlace> place_;
};

RangeScans::Source::Source(const RangeScans& scans, std::size_t scan, std::size_t end,
                           bool in_world)
    : scans_(scans), scan_(scan), end_(end), in_world_(in_world) {
  schema_.position_type = scans.precision_;
  if (in_world) schema_.attributes = {{"scan", ScalarType::kUint8}};
  for (std::size_t k = scan; k < end; ++k) total_ += scans.scans_[k].row_first.back();
}

/// Casts the next rows of one scan; false where there is none left.
bool RangeScans::Source::next_block() {
  while (scan_ < end_ && row_ + 1 == scans_.scans_[scan_].row_first.size()) {
    ++scan_;
    row_ = 0;
  }
  if (scan_ == end_) return false;
  const std::vector<std::uint64_t>& first = scans_.scans_[scan_].row_first;
  std::size_t stop = row_ + 1;
  while (stop + 1 < first.size() && first[stop] - first[row_] < kBlockPoints) ++stop;
  block_.resize(first[stop] - first[row_]);
  tbb::parallel_for(row_, stop, [&](std::size_t row) {
    scans_.cast_row(scan_, row, block_.data() + (first[row] - first[row_]));
  });
  block_scan_ = scan_;
  block_next_ = 0;
  row_ = stop;
  return true;
}

std::optional<ScannerPlace> RangeScans::Source::place_of(const Scan& scan) const {
  std::optional<ScannerPlace> place = scan.scanner;
  if (!place || !in_world_) return place;
  const RigidMotion& motion = scan.pose.motion;
  place->vector =
      place->is_direction ? motion.direction(place->vector) : motion.point(place->vector);
  return place;
}

bool RangeScans::Source::read(PointCloud& batch, std::size_t capacity) {
  batch.schema = schema_;
  batch.clear();
  while (block_next_ == block_.size())
    if (!next_block()) return false;
  const Scan& scan = scans_.scans_[block_scan_];
  const std::size_t count = std::min(capacity, block_.size() - block_next_);
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 own = block_[block_next_ + k];
    const Vec3 p = in_world_ ? scan.pose.motion.point(own) : own;
    batch.positions.push_back(
        schema_.position_type == ScalarType::kFloat32 ? portable::rounded_to_float(p) : p);
  }
  if (in_world_) batch.attributes.assign(count, static_cast<std::byte>(block_scan_));
  place_ = place_of(scan);
  block_next_ += count;
  given_ += count;
  return true;
}

std::uint64_t RangeScans::points() const {
  std::uint64_t sum = 0;
  for (const Scan& scan : scans_) sum += scan.row_first.back();
  return sum;
}

std::unique_ptr<PointSource> RangeScans::scan(int scan) const {
  const auto index = static_cast<std::size_t>(scan);
  return std::make_unique<Source>(*this, index, index + 1, false);
}

std::unique_ptr<PointSource> RangeScans::all() const {
  return std::make_unique<Source>(*this, 0, scans_.size(), true);
}

}  // namespace orbweave
