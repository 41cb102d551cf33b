#include "io/clouds/las/las_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "io/clouds/las/las_coordinate_system.h"
#include "io/clouds/las/las_extra_bytes.h"
#include "io/clouds/las/las_header.h"
#include "io/clouds/las/las_layout.h"
#include "io/clouds/las/las_records.h"
#include "io/clouds/las/las_variable_records.h"
#include "io/text/counted_noun.h"

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
    if (!records_->restrict(first, count)) return false;
    rows_ = count;
    return true;
  }
  void skip_parts(const std::function<bool(const Box&)>& is_outside) override {
    is_outside_ = is_outside;
  }
  void skip_attributes(const std::function<bool(const std::string&)>& is_wanted) override {
    layout_.keep_attributes(is_wanted);
  }
  std::uint64_t bytes_read() const override { return records_->bytes_read(); }
  std::uint64_t bytes_total() const override { return file_->size(); }

  bool read(PointCloud& batch, std::size_t capacity) override {
    batch.clear();
    batch.schema = layout_.schema();
    if (is_outside_) {
      if (lies_outside()) skip_all();
      is_outside_ = nullptr;
    }
    while (batch.size() < capacity && !is_skipped_) {
      const std::size_t count = next_records(capacity - batch.size());
      if (count == 0) break;
      layout_.append(block_.data(), keep_usable(count), batch);
    }
    return !batch.empty();
  }

  FileFacts facts() const override {
    FileFacts facts;
    facts.format = header_.is_compressed ? "LAZ" : "LAS";
    facts.version = "1." + std::to_string(header_.version_minor);
    facts.point_format = header_.point_format;
    facts.software = header_.software;
    facts.declared_bounds = header_.bounds;
    if (const std::uint64_t more = uncounted_points(); more != 0)
      facts.left_out.push_back("bytes of " + counted_points(more) +
                               " behind those that the header counts");
    return facts;
  }

  DroppedPoints left_out() const override {
    DroppedPoints dropped;
    if (withheld_ != 0) dropped["withheld"] = withheld_;
    if (is_skipped_ && *rows_ != 0) dropped[kOutsideCrop] = *rows_;
    return dropped;
  }
  std::string coordinate_system() const override {
    return las::coordinate_system(*file_, variable_records_, header_.says_wkt);
  }
  std::optional<Vec3> meters_per_unit() const override {
    return las::meters_per_unit(*file_, variable_records_, header_.says_wkt);
  }

 private:
  /// Whole records between the points that are counted and what comes next, as a program leaves
  /// them that did not come to write the count. Of compressed points and formats with waveforms,
  /// which may lie there, nothing is known, and zeros are filler.
  std::uint64_t uncounted_points() const {
    constexpr std::array kWithWaveforms = {4, 5, 9, 10};
    const bool has_waveforms =
        std::ranges::find(kWithWaveforms, header_.point_format) != kWithWaveforms.end();
    if (header_.is_compressed || has_waveforms) return 0;
    const std::uint64_t begin =
        header_.point_data_offset + header_.points * std::uint64_t{header_.record_bytes};
    std::uint64_t end = file_->size();
    if (header_.extended_records != 0 && header_.extended_records_offset >= begin)
      end = std::min(end, header_.extended_records_offset);
    const std::uint64_t records = end > begin ? (end - begin) / header_.record_bytes : 0;
    if (records == 0) return 0;
    std::vector<std::byte> first(header_.record_bytes);
    file_->read(begin, first);
    const bool is_filler =
        std::ranges::all_of(first, [](std::byte b) { return b == std::byte{0}; });
    return is_filler ? 0 : records;
  }

  /// Whether the bounds in the header are outside, and the first points do not contradict them.
  bool lies_outside() {
    constexpr std::size_t kLooked = 1024;
    const Box& bounds = header_.bounds;
    if (bounds.empty() || !is_finite(bounds.min) || !is_finite(bounds.max) || !is_outside_(bounds))
      return false;
    waiting_ = read_block(kLooked);
    PointCloud first;
    first.schema = layout_.schema();
    layout_.append(block_.data(), waiting_, first);
    // Some writers round bounds to the grid of the coordinates, some do not.
    Box room = bounds;
    for (int axis = 0; axis < 3; ++axis) {
      room.min[axis] -= std::abs(header_.scale[axis]);
      room.max[axis] += std::abs(header_.scale[axis]);
    }
    return std::ranges::all_of(first.positions, [&](Vec3 p) { return room.contains(p); });
  }

  void skip_all() {
    is_skipped_ = true;
    if (!rows_) rows_ = header_.points;
  }

  /// The next records at the front of the block, at most `most`; 0 at the end.
  std::size_t next_records(std::size_t most) {
    if (waiting_ == 0) return read_block(most);
    const std::size_t bytes = layout_.record_bytes();
    std::memmove(block_.data(), block_.data() + waiting_at_ * bytes, waiting_ * bytes);
    waiting_at_ = std::min(most, waiting_);
    waiting_ -= waiting_at_;
    return waiting_at_;
  }

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
  std::optional<std::uint64_t> rows_;  ///< that are left, where not all are
  std::function<bool(const Box&)> is_outside_;
  std::size_t waiting_ = 0;     ///< records that were looked at and not handed out
  std::size_t waiting_at_ = 0;  ///< the first of them in the block
  bool is_skipped_ = false;
};

}  // namespace

std::unique_ptr<PointSource> open_las_source(std::unique_ptr<RandomAccess> file) {
  return std::make_unique<LasSource>(std::move(file));
}

}  // namespace orbweave
