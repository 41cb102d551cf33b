#include "io/clouds/las/las_records.h"

#include <algorithm>

#include "io/clouds/laz/laz_reader.h"
#include "io/error.h"

namespace orbweave::las {
namespace {

/// The header has been checked: the file is long enough for all of them.
class PlainRecords final : public Records {
 public:
  PlainRecords(const RandomAccess& file, const Header& header)
      : file_(file),
        next_(header.point_data_offset),
        left_(header.points),
        record_bytes_(header.record_bytes) {}

  std::size_t read(std::span<std::byte> records) override {
    const std::size_t count =
        static_cast<std::size_t>(std::min<std::uint64_t>(left_, records.size() / record_bytes_));
    file_.read(next_, records.first(count * record_bytes_));
    next_ += count * record_bytes_;
    left_ -= count;
    return count;
  }
  bool restrict(std::uint64_t first, std::uint64_t count) override {
    if (first > left_) return false;
    next_ += first * record_bytes_;
    left_ = std::min(left_ - first, count);
    return true;
  }
  std::uint64_t bytes_read() const override { return next_; }

 private:
  const RandomAccess& file_;
  std::uint64_t next_;
  std::uint64_t left_;
  std::size_t record_bytes_;
};

class CompressedRecords final : public Records {
 public:
  CompressedRecords(const RandomAccess& file, const Header& header,
                    std::span<const std::byte> laszip)
      : begin_(header.point_data_offset),
        reader_(file, laszip, begin_, header.points, header.point_format, header.record_bytes) {}
  std::size_t read(std::span<std::byte> records) override { return reader_.read(records); }
  std::uint64_t bytes_read() const override { return begin_ + reader_.bytes_read(); }

 private:
  std::uint64_t begin_;
  LazReader reader_;
};

}  // namespace

std::unique_ptr<Records> open_records(const RandomAccess& file, const Header& header,
                                      const VariableRecords& records) {
  if (!header.is_compressed) return std::make_unique<PlainRecords>(file, header);
  if (!records.laszip)
    throw_bad_input("the points are compressed, but nothing says how",
                    {.file = file.name(),
                     .place = "variable length records",
                     .found = "none of \"laszip encoded\"",
                     .expected = "its record 22204"});
  return std::make_unique<CompressedRecords>(file, header, read_payload(file, records.laszip));
}

}  // namespace orbweave::las
