// Integers that are coded as their difference from a prediction.
//
// Source: Isenburg, LASzip (2013); format of LASzip (docs/dev/laz.md). First
// comes the width k of the difference c: k = 0 for 0 and 1, else -2^k < c <= -2^(k-1) or
// 2^(k-1) < c <= 2^k. Then the place of c in that set; only its upper 8 bits have a model.
#pragma once

#include <array>
#include <cstdint>

#include "io/clouds/laz/adaptive_model.h"
#include "io/clouds/laz/range_decoder.h"

namespace orbweave::laz {

/// The differences of integers of kBits bits, whatever their context.
template <unsigned kBits>
class DifferenceDecoder {
 public:
  void reset() {
    zero_or_one_.reset();
    reset_all(width1_, width2_, width3_, width4_, width5_, width6_, width7_);
    wide_.reset();
  }

  /// Two's complement.
  std::uint32_t decode(RangeDecoder& in, unsigned width) {
    if (width == 0) return in.bit(zero_or_one_);
    if (width == 32) return 0x80000000U;
    const std::uint32_t place = place_in(in, width);
    return place >= 1U << (width - 1) ? place + 1 : place - ((1U << width) - 1);
  }

 private:
  template <typename... Models>
  static void reset_all(Models&... models) {
    (models.reset(), ...);
  }
  std::uint32_t place_in(RangeDecoder& in, unsigned width) {
    switch (width) {
      case 1:
        return in.symbol(width1_);
      case 2:
        return in.symbol(width2_);
      case 3:
        return in.symbol(width3_);
      case 4:
        return in.symbol(width4_);
      case 5:
        return in.symbol(width5_);
      case 6:
        return in.symbol(width6_);
      case 7:
        return in.symbol(width7_);
      case 8:
        return in.symbol(wide_[0]);
      default: {
        const std::uint32_t upper = in.symbol(wide_[width - 8]);
        return upper << (width - 8) | in.bits(width - 8);
      }
    }
  }

  AdaptiveBit zero_or_one_;
  AdaptiveModel<2> width1_;
  AdaptiveModel<4> width2_;
  AdaptiveModel<8> width3_;
  AdaptiveModel<16> width4_;
  AdaptiveModel<32> width5_;
  AdaptiveModel<64> width6_;
  AdaptiveModel<128> width7_;
  ModelBank<256> wide_{kBits - 7};  ///< widths 8 to kBits; most data uses few of them
};

/// Integers of kBits bits; the width of their difference has one model per context.
template <unsigned kBits, unsigned kContexts>
class IntegerDecoder {
 public:
  void reset() {
    for (auto& model : widths_) model.reset();
    differences_.reset();
    width_ = 0;
  }

  /// Correct in the lower kBits bits, modulo 2^kBits; `predicted` likewise.
  std::uint32_t decode(RangeDecoder& in, std::uint32_t predicted, unsigned context = 0) {
    width_ = in.symbol(widths_[context]);
    return predicted + differences_.decode(in, width_);
  }
  /// Of the last difference.
  unsigned width() const { return width_; }

 private:
  std::array<AdaptiveModel<kBits + 1>, kContexts> widths_;
  DifferenceDecoder<kBits> differences_;
  unsigned width_ = 0;
};

}  // namespace orbweave::laz
