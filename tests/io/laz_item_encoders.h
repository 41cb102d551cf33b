// Encoders of what several items of a LAZ record have in common.
#pragma once

#include <array>
#include <cstdint>

#include "tests/io/laz_range_encoder.h"

namespace orbweave::test {

class GpsTimeEncoder {
 public:
  explicit GpsTimeEncoder(bool codes_unchanged)
      : shift_(codes_unchanged ? 1 : 0), first_(5 + shift_), multiples_(515 + shift_) {}
  void start(std::uint64_t time) { sequences_[0].time = time; }
  /// Layers never hand over an unchanged time.
  void encode(RangeEncoder& out, std::uint64_t time);

 private:
  struct Sequence {
    std::uint64_t time = 0;
    std::int32_t step = 0;
    int surprises = 0;
  };
  bool fits(unsigned sequence, std::uint64_t time) const;
  void change_sequence(RangeEncoder& out, std::uint64_t time);
  void encode_step(RangeEncoder& out, std::uint32_t difference);
  void surprise(std::uint32_t difference);

  unsigned shift_;
  std::array<Sequence, 4> sequences_{};
  unsigned current_ = 0, newest_ = 0;
  SlowModel first_, multiples_;
  IntegerEncoder differences_{32};
};

class ColourEncoder {
 public:
  void encode(RangeEncoder& out, std::array<std::uint16_t, 3>& last,
              const std::array<std::uint16_t, 3>& colour);

 private:
  SlowModel changed_{128};
  SlowModels bytes_{256};
};

class InfraredEncoder {
 public:
  void encode(RangeEncoder& out, std::uint16_t& last, std::uint16_t value);

 private:
  SlowModel changed_{4};
  SlowModels bytes_{256};
};

class WavePacketEncoder {
 public:
  using Packet = std::array<std::uint8_t, 29>;
  void encode(RangeEncoder& out, Packet& last, const Packet& packet);

 private:
  SlowModel index_{256};
  SlowModels kinds_{4};
  IntegerEncoder offset_{32}, size_{32}, return_point_{32}, direction_{32};
  unsigned last_kind_ = 0;
  std::uint32_t last_difference_ = 0;
};

}  // namespace orbweave::test
