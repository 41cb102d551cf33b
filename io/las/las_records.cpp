#include "io/las/las_records.h"

#include <algorithm>

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
  std::uint64_t bytes_read() const override { return next_; }

 private:
  const RandomAccess& file_;
  std::uint64_t next_;
  std::uint64_t left_;
  std::size_t record_bytes_;
};

}  // namespace

std::unique_ptr<Records> open_records(const RandomAccess& file, const Header& header,
                                      const VariableRecords&) {
  if (header.is_compressed)
    throw_usage("this program was built without the decoder of LAZ files",
                {.file = file.name(), .advice = "Convert the file to LAS."});
  return std::make_unique<PlainRecords>(file, header);
}

}  // namespace orbweave::las
