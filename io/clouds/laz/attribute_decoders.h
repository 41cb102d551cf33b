// GPS times, colours and wave packets of LAZ points. Point formats 0 to 5 and 6 to 10 code them
// alike, up to what is named here.
//
// Source: format of LASzip (docs/dev/laz.md), items GPSTIME11, RGB12, WAVEPACKET13 and their
// successors.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "io/clouds/laz/adaptive_model.h"
#include "io/clouds/laz/integer_decoder.h"
#include "io/clouds/laz/range_decoder.h"

namespace orbweave::laz {

/// GPS times as the bits of doubles. Up to four sequences of times are followed side by side; the
/// next time continues one of them by a multiple of its usual step.
class GpsTimeDecoder {
 public:
  /// `codes_unchanged`: equal times have a code of their own (point formats 0 to 5). In the layers
  /// of formats 6 to 10 they are marked elsewhere and cost nothing here.
  explicit GpsTimeDecoder(bool codes_unchanged) : codes_unchanged_(codes_unchanged) {}
  void reset(std::uint64_t first_time);
  std::uint64_t decode(RangeDecoder& in);

 private:
  struct Sequence {
    std::uint64_t time = 0;
    std::int32_t step = 0;
    int surprises = 0;  ///< steps that did not fit, in a row or nearly so
  };

  /// True when the time is known, false when another sequence was chosen.
  bool first_step(RangeDecoder& in);
  bool next_step(RangeDecoder& in);
  void multiple(RangeDecoder& in, int code);
  void begin_sequence(RangeDecoder& in);
  void advance(std::uint32_t difference);
  void surprise(std::uint32_t difference);

  bool codes_unchanged_;
  std::array<Sequence, 4> sequences_{};
  unsigned current_ = 0;
  unsigned newest_ = 0;
  // Symbol counts of the older form; the newer one has one fewer of each.
  AdaptiveModel<516> multiples_with_unchanged_;
  AdaptiveModel<515> multiples_;
  AdaptiveModel<6> first_with_unchanged_;
  AdaptiveModel<5> first_;
  IntegerDecoder<32, 9> differences_;
};

/// Red, green and blue: which of the six bytes changed, then their differences; green and blue
/// are predicted to change as red did.
class ColourDecoder {
 public:
  using Colour = std::array<std::uint16_t, 3>;
  void reset();
  /// `last` becomes the next colour.
  void decode(RangeDecoder& in, Colour& last);

 private:
  AdaptiveModel<128> changed_;
  std::array<AdaptiveModel<256>, 6> bytes_;
};

/// The near infrared channel of point formats 8 and 10.
class InfraredDecoder {
 public:
  void reset();
  void decode(RangeDecoder& in, std::uint16_t& last);

 private:
  AdaptiveModel<4> changed_;
  std::array<AdaptiveModel<256>, 2> bytes_;
};

/// The wave packet's 29 bytes.
class WavePacketDecoder {
 public:
  static constexpr std::size_t kBytes = 29;
  using Packet = std::array<std::byte, kBytes>;
  void reset();
  void decode(RangeDecoder& in, Packet& last);

 private:
  AdaptiveModel<256> index_;
  std::array<AdaptiveModel<4>, 4> offset_kind_;
  IntegerDecoder<32, 1> offset_difference_;
  IntegerDecoder<32, 1> size_;
  IntegerDecoder<32, 1> return_point_;
  IntegerDecoder<32, 3> direction_;
  unsigned last_kind_ = 0;
  std::uint32_t last_difference_ = 0;
};

}  // namespace orbweave::laz
