#include "io/clouds/las/las_source.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

#include "io/clouds/las/las_coordinate_system.h"
#include "io/clouds/las/las_extra_bytes.h"
#include "io/clouds/las/las_header.h"
#include "io/clouds/las/las_layout.h"
#include "io/clouds/las/las_records.h"
#include "io/clouds/las/las_variable_records.h"

namespace orbweave {
namespace {

/// Records decoded at a time; such that they stay in the cache while column after column is taken.
constexpr std::size_t kBlockBytes = std::size_t{128} << 10;

las::Layout layout_of(const RandomAccess& file, const las::Header& header,
                      const las::VariableRecords& records) {
  const std::vector<std::byte> described = las::read_payload(file, records.extra_bytes);
  return las::Layout(header,
                     las::extra_values(described, las::point_format_bytes(header.point_format),
                                       header.record_bytes));
}

class LasSource final : public PointSource {
 public:
  explicit LasSource(std::unique_ptr<RandomAccess> file)
      : file_(std::move(file)),
        header_(las::read_header(*file_)),
        variable_records_(las::find_variable_records(*file_, header_)),
        layout_(layout_of(*file_, header_, variable_records_)),
        records_(las::open_records(*file_, header_, variable_records_)) {}

  const PointSchema& schema() const override { return layout_.schema(); }
  std::optional<std::uint64_t> declared_points() const override { return header_.points; }
  bool keeps_declared_points() const override { return false; }
  bool restrict_rows(std::uint64_t first, std::uint64_t count) override {
    return records_->restrict(first, count);
  }
  std::uint64_t bytes_read() const override { return records_->bytes_read(); }
  std::uint64_t bytes_total() const override { return file_->size(); }

  bool read(PointCloud& batch, std::size_t capacity) override {
    batch.clear();
    batch.schema = layout_.schema();
    while (batch.size() < capacity) {
      const std::size_t count = read_block(capacity - batch.size());
      if (count == 0) break;
      layout_.append(block_.data(), keep_usable(count), batch);
    }
    return !batch.empty();
  }

  DroppedPoints left_out() const override {
    return withheld_ == 0 ? DroppedPoints{} : DroppedPoints{{"withheld", withheld_}};
  }
  std::string coordinate_system() const override {
    return las::coordinate_system(*file_, variable_records_, header_.says_wkt);
  }
  std::optional<Vec3> meters_per_unit() const override {
    return las::meters_per_unit(*file_, variable_records_, header_.says_wkt);
  }

 private:
  /// Reads the next records, at most `most`; 0 at the end.
  std::size_t read_block(std::size_t most) {
    const std::size_t bytes = layout_.record_bytes();
    const std::size_t fit = std::max<std::size_t>(1, kBlockBytes / bytes);
    if (block_.empty())
      block_.resize(bytes * static_cast<std::size_t>(std::min<std::uint64_t>(fit, header_.points)));
    const std::size_t wanted = std::min(most, block_.size() / bytes);
    return wanted == 0 ? 0 : records_->read(std::span(block_).first(wanted * bytes));
  }

  /// Moves the records that are not withheld together; returns their number.
  std::size_t keep_usable(std::size_t count) {
    const std::size_t bytes = layout_.record_bytes();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const std::byte* record = block_.data() + i * bytes;
      if (layout_.is_withheld(record)) continue;
      if (kept != i) std::memcpy(block_.data() + kept * bytes, record, bytes);
      ++kept;
    }
    withheld_ += count - kept;
    return kept;
  }

  std::unique_ptr<RandomAccess> file_;
  las::Header header_;
  las::VariableRecords variable_records_;
  las::Layout layout_;
  std::unique_ptr<las::Records> records_;
  std::vector<std::byte> block_;
  std::uint64_t withheld_ = 0;
};

}  // namespace

std::unique_ptr<PointSource> open_las_source(std::unique_ptr<RandomAccess> file) {
  return std::make_unique<LasSource>(std::move(file));
}

}  // namespace orbweave
