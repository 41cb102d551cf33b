#include "tests/io/laz_item_encoders.h"

#include <algorithm>
#include <cmath>

#include "tests/io/laz_encoder.h"

namespace orbweave::test {
namespace {

constexpr unsigned kMultiples = 511;  // codes of multiples; behind them those of other sequences

int low(std::uint16_t value) { return value & 0xff; }
int high(std::uint16_t value) { return value >> 8; }
unsigned modulo256(int value) { return static_cast<unsigned>(value) & 0xff; }

}  // namespace

bool GpsTimeEncoder::fits(unsigned sequence, std::uint64_t time) const {
  const auto difference = static_cast<std::int64_t>(time - sequences_[sequence].time);
  return difference == static_cast<std::int32_t>(difference);
}

void GpsTimeEncoder::encode(RangeEncoder& out, std::uint64_t time) {
  Sequence& now = sequences_[current_];
  if (shift_ == 1 && now.time == time) {
    now.step == 0 ? out.symbol(first_, 0) : out.symbol(multiples_, kMultiples);
  } else if (!fits(current_, time)) {
    change_sequence(out, time);
  } else if (now.step == 0) {
    const auto difference = static_cast<std::uint32_t>(time - now.time);
    out.symbol(first_, shift_);
    differences_.encode(out, 0, difference, 0);
    now = {time, static_cast<std::int32_t>(difference), 0};
  } else {
    encode_step(out, static_cast<std::uint32_t>(time - now.time));
    sequences_[current_].time = time;
  }
}

void GpsTimeEncoder::change_sequence(RangeEncoder& out, std::uint64_t time) {
  const bool fresh = sequences_[current_].step == 0;
  SlowModel& model = fresh ? first_ : multiples_;
  const unsigned full = shift_ + (fresh ? 1 : kMultiples);
  for (unsigned other = 1; other < 4; ++other) {
    if (!fits((current_ + other) % 4, time)) continue;
    out.symbol(model, full + other);
    current_ = (current_ + other) % 4;
    return encode(out, time);
  }
  out.symbol(model, full);
  newest_ = (newest_ + 1) % 4;
  differences_.encode(out, static_cast<std::uint32_t>(sequences_[current_].time >> 32),
                      static_cast<std::uint32_t>(time >> 32), 8);
  out.bits(32, static_cast<std::uint32_t>(time));
  current_ = newest_;
  sequences_[current_] = {time, 0, 0};
}

void GpsTimeEncoder::encode_step(RangeEncoder& out, std::uint32_t difference) {
  Sequence& now = sequences_[current_];
  const double ratio = static_cast<double>(static_cast<std::int32_t>(difference)) / now.step;
  const int factor = static_cast<int>(std::clamp(std::round(ratio), -10.0, 500.0));
  const std::uint32_t predicted =
      static_cast<std::uint32_t>(factor) * static_cast<std::uint32_t>(now.step);
  const unsigned context = factor == 1     ? 1
                           : factor == 0   ? 7
                           : factor == 500 ? 4
                           : factor == -10 ? 6
                           : factor < 0    ? 5
                           : factor < 10   ? 2
                                           : 3;
  out.symbol(multiples_, static_cast<unsigned>(factor >= 0 ? factor : 500 - factor));
  differences_.encode(out, predicted, difference, context);
  if (factor == 1) now.surprises = 0;
  if (factor == 0 || factor == 500 || factor == -10) surprise(difference);
}

void GpsTimeEncoder::surprise(std::uint32_t difference) {
  Sequence& now = sequences_[current_];
  if (++now.surprises <= 3) return;
  now.surprises = 0;
  now.step = static_cast<std::int32_t>(difference);
}

void ColourEncoder::encode(RangeEncoder& out, std::array<std::uint16_t, 3>& last,
                           const std::array<std::uint16_t, 3>& colour) {
  const bool grey = colour[1] == colour[0] && colour[2] == colour[0];
  unsigned changed = grey ? 0 : 64;
  for (unsigned i = 0; i < 3; ++i) {
    if (low(colour[i]) != low(last[i])) changed |= 1U << 2 * i;
    if (high(colour[i]) != high(last[i])) changed |= 2U << 2 * i;
  }
  out.symbol(changed_, changed);
  if (changed & 1) out.symbol(bytes_[0], modulo256(low(colour[0]) - low(last[0])));
  if (changed & 2) out.symbol(bytes_[1], modulo256(high(colour[0]) - high(last[0])));
  for (unsigned byte = 0; byte < 2 && !grey; ++byte) {
    const auto of = [&](std::uint16_t value) { return byte == 0 ? low(value) : high(value); };
    const auto code = [&](unsigned channel, int change) {
      const int predicted = std::clamp(change + of(last[channel]), 0, 255);
      if (changed & (1U << byte) << 2 * channel)
        out.symbol(bytes_[2 * channel + byte], modulo256(of(colour[channel]) - predicted));
    };
    const int red = of(colour[0]) - of(last[0]);
    code(1, red);
    code(2, (red + of(colour[1]) - of(last[1])) / 2);
  }
  last = colour;
}

void InfraredEncoder::encode(RangeEncoder& out, std::uint16_t& last, std::uint16_t value) {
  const bool low_changes = low(value) != low(last);
  const bool high_changes = high(value) != high(last);
  out.symbol(changed_, (low_changes ? 1U : 0U) + (high_changes ? 2U : 0U));
  if (low_changes) out.symbol(bytes_[0], modulo256(low(value) - low(last)));
  if (high_changes) out.symbol(bytes_[1], modulo256(high(value) - high(last)));
  last = value;
}

void WavePacketEncoder::encode(RangeEncoder& out, Packet& last, const Packet& packet) {
  const auto offset = take<std::uint64_t>(&packet[1]);
  const auto last_offset = take<std::uint64_t>(&last[1]);
  const auto last_size = take<std::uint32_t>(&last[9]);
  const auto difference = static_cast<std::int64_t>(offset - last_offset);
  const unsigned kind = difference == 0                                       ? 0
                        : difference == last_size                             ? 1
                        : difference == static_cast<std::int32_t>(difference) ? 2
                                                                              : 3;
  out.symbol(index_, packet[0]);
  out.symbol(kinds_[last_kind_], kind);
  last_kind_ = kind;
  if (kind == 2) {
    offset_.encode(out, last_difference_, static_cast<std::uint32_t>(difference));
    last_difference_ = static_cast<std::uint32_t>(difference);
  } else if (kind == 3) {
    out.long_word(offset);
  }
  size_.encode(out, last_size, take<std::uint32_t>(&packet[9]));
  return_point_.encode(out, take<std::uint32_t>(&last[13]), take<std::uint32_t>(&packet[13]));
  for (unsigned axis = 0; axis < 3; ++axis)
    direction_.encode(out, take<std::uint32_t>(&last[17 + 4 * axis]),
                      take<std::uint32_t>(&packet[17 + 4 * axis]), axis);
  last = packet;
}

}  // namespace orbweave::test
