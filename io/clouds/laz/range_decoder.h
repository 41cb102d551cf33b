// The range decoder of LAZ files: symbols, bits and plain words from a part of a file.
//
// Source: Amir Said, Introduction to Arithmetic Coding, HPL-2004-76, with the widths of LASzip
// (docs/dev/laz.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/clouds/laz/adaptive_model.h"
#include "io/streams/random_access.h"

namespace orbweave::laz {

/// Reads one coded stream. The bytes are fetched window by window, so that memory does not depend
/// on what a file claims of the stream's length.
class RangeDecoder {
 public:
  /// Begins at the bytes [begin, end) of `file`, which must outlive the decoder.
  /// Throws Error (bad input) when they are no beginning of a stream.
  void open(const RandomAccess& file, std::uint64_t begin, std::uint64_t end);
  /// The byte of the file behind those used. At the end of a stream it is the stream's end.
  std::uint64_t position() const { return window_end_ - static_cast<std::uint64_t>(stop_ - next_); }

  template <unsigned kSymbols>
  unsigned symbol(AdaptiveModel<kSymbols>& model) {
    model.prepare();
    const std::uint32_t step = length_ >> AdaptiveModel<kSymbols>::kProbabilityBits;
    const unsigned found = model.find(value_ / step);
    const std::uint32_t low = model.begin_of(found) * step;
    const std::uint32_t high = found + 1 == kSymbols ? length_ : model.begin_of(found + 1) * step;
    narrow(low, high - low);
    model.count(found);
    return found;
  }

  bool bit(AdaptiveBit& model) {
    const std::uint32_t zeros =
        model.zero_probability() * (length_ >> AdaptiveBit::kProbabilityBits);
    const bool one = value_ >= zeros;
    if (one)
      narrow(zeros, length_ - zeros);
    else
      narrow(0, zeros);
    model.count(one);
    return one;
  }

  /// An unsigned number of `count` <= 32 bits that were coded as they are.
  std::uint32_t bits(unsigned count) {
    if (count <= 19) return few_bits(count);
    const std::uint32_t low = few_bits(16);
    return few_bits(count - 16) << 16 | low;
  }
  std::uint32_t word() { return bits(32); }
  std::uint64_t long_word() {
    const std::uint64_t low = word();
    return static_cast<std::uint64_t>(word()) << 32 | low;
  }

  /// Throws Error (bad input) for symbols that make no sense, with the place.
  [[noreturn]] void throw_damaged() const;

 private:
  static constexpr std::uint32_t kShortest = 1U << 24;

  std::uint32_t few_bits(unsigned count) {
    const std::uint32_t step = length_ >> count;
    const std::uint32_t number = value_ / step;
    if (number >> count) [[unlikely]]
      throw_damaged();
    narrow(number * step, step);
    return number;
  }
  /// Keeps value_ < length_, on which everything above stands.
  void narrow(std::uint32_t low, std::uint32_t length) {
    value_ -= low;
    length_ = length;
    while (length_ < kShortest) {
      value_ = value_ << 8 | next_byte();
      length_ <<= 8;
    }
  }
  std::uint8_t next_byte() {
    if (next_ == stop_) [[unlikely]]
      refill();
    return *next_++;
  }
  void refill();

  std::uint32_t value_ = 0;
  std::uint32_t length_ = 0xffffffffU;
  const std::uint8_t* next_ = nullptr;  ///< into window_
  const std::uint8_t* stop_ = nullptr;
  std::vector<std::uint8_t> window_;
  std::uint64_t window_end_ = 0;  ///< the byte of the file behind the window
  std::uint64_t end_ = 0;
  const RandomAccess* file_ = nullptr;
};

}  // namespace orbweave::laz
