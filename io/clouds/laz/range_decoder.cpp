#include "io/clouds/laz/range_decoder.h"

#include <algorithm>
#include <string>

#include "io/error.h"

namespace orbweave::laz {
namespace {

constexpr std::uint64_t kWindowBytes = 64 * 1024;

}  // namespace

void RangeDecoder::open(const RandomAccess& file, std::uint64_t begin, std::uint64_t end) {
  file_ = &file;
  window_end_ = begin;
  end_ = end;
  next_ = stop_ = nullptr;
  value_ = 0;
  length_ = 0xffffffffU;
  for (int byte = 0; byte < 4; ++byte) value_ = value_ << 8 | next_byte();
  if (value_ == length_) throw_damaged();
}

void RangeDecoder::refill() {
  if (window_end_ >= end_)
    throw_bad_input("compressed points end too soon",
                    {.file = file_->name(),
                     .place = "byte " + std::to_string(end_),
                     .found = "the end of their bytes",
                     .expected = "more of them",
                     .advice = "Copy or download the file again."});
  window_.resize(std::min(kWindowBytes, end_ - window_end_));
  file_->read(window_end_, std::as_writable_bytes(std::span(window_)));
  window_end_ += window_.size();
  next_ = window_.data();
  stop_ = next_ + window_.size();
}

void RangeDecoder::throw_damaged() const {
  throw_bad_input("compressed points are damaged", {.file = file_->name(),
                                                    .place = "byte " + std::to_string(position()),
                                                    .found = "a code that no encoder writes",
                                                    .advice = "Copy or download the file again."});
}

}  // namespace orbweave::laz
