#include "io/clouds/laz/attribute_decoders.h"

#include <algorithm>

#include "io/text/little_endian.h"

namespace orbweave::laz {
namespace {

// Multiples of the usual step have the codes 0 to kLargestMultiple and, for the negative ones,
// those behind it.
constexpr int kLargestMultiple = 500;
constexpr int kSmallestMultiple = -10;
constexpr int kMultipleCodes = kLargestMultiple - kSmallestMultiple + 1;
constexpr int kPatience = 3;  ///< surprises until the usual step is given up

std::uint32_t times(int factor, std::int32_t step) {
  return static_cast<std::uint32_t>(factor) * static_cast<std::uint32_t>(step);
}

std::uint8_t low_byte(std::uint16_t value) { return static_cast<std::uint8_t>(value & 0xff); }
std::uint8_t high_byte(std::uint16_t value) { return static_cast<std::uint8_t>(value >> 8); }
std::uint16_t two_bytes(std::uint8_t low, std::uint8_t high) {
  return static_cast<std::uint16_t>(high << 8 | low);
}
std::uint8_t clamped(int value) { return static_cast<std::uint8_t>(std::clamp(value, 0, 255)); }
/// Modulo 256.
std::uint8_t add(RangeDecoder& in, AdaptiveModel<256>& model, std::uint8_t predicted) {
  return static_cast<std::uint8_t>(in.symbol(model) + predicted);
}

}  // namespace

void GpsTimeDecoder::reset(std::uint64_t first_time) {
  sequences_ = {};
  sequences_[0].time = first_time;
  current_ = newest_ = 0;
  multiples_with_unchanged_.reset();
  multiples_.reset();
  first_with_unchanged_.reset();
  first_.reset();
  differences_.reset();
}

std::uint64_t GpsTimeDecoder::decode(RangeDecoder& in) {
  // An encoder changes to the sequence it continues, so once a point; with four there is never a
  // reason for more than this.
  constexpr int kMostChanges = 4;
  for (int changes = 0; changes <= kMostChanges; ++changes)
    if (sequences_[current_].step == 0 ? first_step(in) : next_step(in))
      return sequences_[current_].time;
  in.throw_damaged();
}

bool GpsTimeDecoder::first_step(RangeDecoder& in) {
  unsigned code = codes_unchanged_ ? in.symbol(first_with_unchanged_) : in.symbol(first_);
  if (codes_unchanged_ && code-- == 0) return true;
  if (code == 0) {
    const std::uint32_t step = differences_.decode(in, 0, 0);
    sequences_[current_].step = static_cast<std::int32_t>(step);
    sequences_[current_].surprises = 0;
    advance(step);
    return true;
  }
  if (code == 1) {
    begin_sequence(in);
    return true;
  }
  current_ = (current_ + code - 1) % 4;
  return false;
}

bool GpsTimeDecoder::next_step(RangeDecoder& in) {
  int code = static_cast<int>(codes_unchanged_ ? in.symbol(multiples_with_unchanged_)
                                               : in.symbol(multiples_));
  if (code < kMultipleCodes) {
    multiple(in, code);
    return true;
  }
  code -= kMultipleCodes;
  if (codes_unchanged_ && code-- == 0) return true;
  if (code == 0) {
    begin_sequence(in);
    return true;
  }
  current_ = (current_ + static_cast<unsigned>(code)) % 4;
  return false;
}

void GpsTimeDecoder::multiple(RangeDecoder& in, int code) {
  Sequence& sequence = sequences_[current_];
  const int factor = code <= kLargestMultiple ? code : kLargestMultiple - code;
  const std::uint32_t predicted = times(factor, sequence.step);
  if (code == 1) {
    advance(differences_.decode(in, predicted, 1));
    sequence.surprises = 0;
  } else if (code == 0) {
    surprise(differences_.decode(in, 0, 7));
  } else if (factor == kLargestMultiple) {
    surprise(differences_.decode(in, predicted, 4));
  } else if (factor == kSmallestMultiple) {
    surprise(differences_.decode(in, predicted, 6));
  } else {
    const unsigned context = factor < 0 ? 5 : factor < 10 ? 2 : 3;
    advance(differences_.decode(in, predicted, context));
  }
}

void GpsTimeDecoder::begin_sequence(RangeDecoder& in) {
  newest_ = (newest_ + 1) % 4;
  const auto upper = static_cast<std::uint32_t>(sequences_[current_].time >> 32);
  const std::uint64_t time = static_cast<std::uint64_t>(differences_.decode(in, upper, 8)) << 32;
  current_ = newest_;
  sequences_[current_] = {.time = time | in.word()};
}

void GpsTimeDecoder::advance(std::uint32_t difference) {
  const auto signed_difference = static_cast<std::int32_t>(difference);
  sequences_[current_].time += static_cast<std::uint64_t>(std::int64_t{signed_difference});
}

void GpsTimeDecoder::surprise(std::uint32_t difference) {
  Sequence& sequence = sequences_[current_];
  if (++sequence.surprises > kPatience) {
    sequence.step = static_cast<std::int32_t>(difference);
    sequence.surprises = 0;
  }
  advance(difference);
}

void ColourDecoder::reset() {
  changed_.reset();
  for (auto& model : bytes_) model.reset();
}

void ColourDecoder::decode(RangeDecoder& in, Colour& last) {
  const unsigned changed = in.symbol(changed_);
  const Colour before = last;
  std::uint8_t low = low_byte(before[0]);
  std::uint8_t high = high_byte(before[0]);
  if (changed & 1) low = add(in, bytes_[0], low);
  if (changed & 2) high = add(in, bytes_[1], high);
  last[0] = two_bytes(low, high);
  if (!(changed & 64)) {  // grey
    last[1] = last[2] = last[0];
    return;
  }
  std::array<std::uint8_t, 2> green{low_byte(before[1]), high_byte(before[1])};
  std::array<std::uint8_t, 2> blue{low_byte(before[2]), high_byte(before[2])};
  for (unsigned byte = 0; byte < 2; ++byte) {
    const auto of = [&](std::uint16_t value) {
      return static_cast<int>(byte == 0 ? low_byte(value) : high_byte(value));
    };
    int change = of(last[0]) - of(before[0]);
    if (changed & (4U << byte))
      green[byte] = add(in, bytes_[2 + byte], clamped(change + of(before[1])));
    if (changed & (16U << byte)) {
      change = (change + green[byte] - of(before[1])) / 2;
      blue[byte] = add(in, bytes_[4 + byte], clamped(change + of(before[2])));
    }
  }
  last[1] = two_bytes(green[0], green[1]);
  last[2] = two_bytes(blue[0], blue[1]);
}

void InfraredDecoder::reset() {
  changed_.reset();
  for (auto& model : bytes_) model.reset();
}

void InfraredDecoder::decode(RangeDecoder& in, std::uint16_t& last) {
  const unsigned changed = in.symbol(changed_);
  std::uint8_t low = low_byte(last);
  std::uint8_t high = high_byte(last);
  if (changed & 1) low = add(in, bytes_[0], low);
  if (changed & 2) high = add(in, bytes_[1], high);
  last = two_bytes(low, high);
}

void WavePacketDecoder::reset() {
  index_.reset();
  for (auto& model : offset_kind_) model.reset();
  offset_difference_.reset();
  size_.reset();
  return_point_.reset();
  direction_.reset();
  last_kind_ = 0;
  last_difference_ = 0;
}

void WavePacketDecoder::decode(RangeDecoder& in, Packet& last) {
  // Index 0, offset 1, size 9, return point 13, direction 17, 21 and 25.
  std::byte* at = last.data();
  at[0] = static_cast<std::byte>(in.symbol(index_));
  auto offset = load_little<std::uint64_t>(at + 1);
  const auto size = load_little<std::uint32_t>(at + 9);
  last_kind_ = in.symbol(offset_kind_[last_kind_]);
  if (last_kind_ == 1) {
    offset += size;
  } else if (last_kind_ == 2) {
    last_difference_ = offset_difference_.decode(in, last_difference_);
    const auto signed_difference = static_cast<std::int32_t>(last_difference_);
    offset += static_cast<std::uint64_t>(std::int64_t{signed_difference});
  } else if (last_kind_ == 3) {
    offset = in.long_word();
  }
  store_little(at + 1, offset);
  store_little(at + 9, size_.decode(in, size));
  store_little(at + 13, return_point_.decode(in, load_little<std::uint32_t>(at + 13)));
  for (unsigned axis = 0; axis < 3; ++axis)
    store_little(at + 17 + 4 * axis,
                 direction_.decode(in, load_little<std::uint32_t>(at + 17 + 4 * axis), axis));
}

}  // namespace orbweave::laz
