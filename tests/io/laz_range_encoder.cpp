#include "tests/io/laz_range_encoder.h"

#include <algorithm>
#include <bit>

namespace orbweave::test {

SlowModel::SlowModel(unsigned symbols)
    : counts_(symbols, 1),
      begins_(symbols),
      total_(symbols),
      cycle_((symbols + 6) / 2),
      left_(cycle_) {
  spread(total_);
}

void SlowModel::count(unsigned symbol) {
  ++counts_[symbol];
  if (--left_ > 0) return;
  total_ += cycle_;
  if (total_ > 32768) {
    total_ = 0;
    for (auto& count : counts_) total_ += count = (count + 1) / 2;
  }
  spread(total_);
  cycle_ = std::min(cycle_ * 5 / 4, (static_cast<std::uint32_t>(counts_.size()) + 6) * 8);
  left_ = cycle_;
}

void SlowModel::spread(std::uint32_t total) {
  const std::uint32_t scale = 0x80000000U / total;
  std::uint32_t sum = 0;
  for (std::size_t i = 0; i < counts_.size(); sum += counts_[i++]) begins_[i] = scale * sum >> 16;
}

void SlowBit::count(bool bit) {
  if (!bit) ++zeros;
  if (--left > 0) return;
  if ((total += cycle) > 8192) {
    total = (total + 1) / 2;
    zeros = (zeros + 1) / 2;
    if (zeros == total) ++total;
  }
  probability = zeros * (0x80000000U / total) >> 18;
  left = cycle = std::min(cycle * 5 / 4, 64U);
}

void RangeEncoder::add(std::uint32_t to_base) {
  base_ += to_base;
  if (base_ >= to_base) return;
  auto byte = bytes_.rbegin();
  while (*byte == 0xff) *byte++ = 0;
  ++*byte;
}

void RangeEncoder::renormalize() {
  for (; length_ < 1U << 24; length_ <<= 8, base_ <<= 8)
    bytes_.push_back(static_cast<std::uint8_t>(base_ >> 24));
}

void RangeEncoder::symbol(SlowModel& model, unsigned symbol) {
  const std::uint32_t step = length_ >> 15;
  const std::uint32_t low = model.begin_of(symbol) * step;
  length_ = (model.is_last(symbol) ? length_ : model.begin_of(symbol + 1) * step) - low;
  add(low);
  renormalize();
  model.count(symbol);
}

void RangeEncoder::bit(SlowBit& model, bool bit) {
  const std::uint32_t zeros = model.probability * (length_ >> 13);
  length_ = bit ? length_ - zeros : zeros;
  if (bit) add(zeros);
  renormalize();
  model.count(bit);
}

void RangeEncoder::bits(unsigned count, std::uint32_t number) {
  if (count > 19) {
    bits(16, number & 0xffff);
    number >>= 16;
    count -= 16;
  }
  length_ >>= count;
  add(number * length_);
  renormalize();
}

void RangeEncoder::long_word(std::uint64_t number) {
  bits(32, static_cast<std::uint32_t>(number));
  bits(32, static_cast<std::uint32_t>(number >> 32));
}

std::vector<std::uint8_t> RangeEncoder::finish() {
  const bool wide = length_ > 2U << 24;
  add(wide ? 1U << 24 : 1U << 23);
  length_ = wide ? 1U << 23 : 1U << 15;
  renormalize();
  bytes_.insert(bytes_.end(), wide ? 3 : 2, 0);
  return bytes_;
}

void IntegerEncoder::encode(RangeEncoder& out, std::uint32_t predicted, std::uint32_t actual,
                            unsigned context) {
  std::uint32_t difference = actual - predicted;
  if (bits_ == 16)
    difference = static_cast<std::uint32_t>(static_cast<std::int16_t>(difference & 0xffff));
  const bool negative = difference >> 31;
  const std::uint32_t size = negative || difference == 0 ? 0U - difference : difference - 1;
  width_ = static_cast<unsigned>(std::bit_width(size));
  out.symbol(widths_.try_emplace(context, bits_ + 1).first->second, width_);
  if (width_ == 0) {
    out.bit(zero_or_one_, difference == 1);
  } else if (width_ < 32) {
    const std::uint32_t place = negative ? difference + ((1U << width_) - 1) : difference - 1;
    const unsigned raw = width_ > 8 ? width_ - 8 : 0;
    const unsigned symbols = 1U << (width_ - raw);
    out.symbol(places_.try_emplace(width_, symbols).first->second, place >> raw);
    if (raw > 0) out.bits(raw, place & ((1U << raw) - 1));
  }
}

}  // namespace orbweave::test
