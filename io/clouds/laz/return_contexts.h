// Contexts that depend on a point's return number and its pulse's number of returns, and the
// running median that predicts coordinates.
//
// Source: Isenburg, LASzip (2013); the tables are those of the format (docs/dev/laz.md).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace orbweave::laz {

/// Table of kSize rows of single hexadecimal digits; indexed [returns][return_number].
template <std::size_t kSize>
constexpr auto table_of(const std::array<std::string_view, kSize>& rows) {
  std::array<std::array<std::uint8_t, kSize>, kSize> table{};
  for (std::size_t n = 0; n < kSize; ++n)
    for (std::size_t r = 0; r < kSize; ++r) {
      const char digit = rows[n][r];
      table[n][r] = static_cast<std::uint8_t>(digit <= '9' ? digit - '0' : digit - 'a' + 10);
    }
  return table;
}

/// 16 contexts of point formats 0 to 5. Valid pairs come first; the rest keeps files apart that
/// count from 0, know only one of the numbers, or exchange them.
inline constexpr auto kReturnContexts16 =
    table_of<8>({"fedcba98", "e0136aa9", "d1247bba", "c3458ccb", "b6789ddc", "aabcdeed", "9abcdefe",
                 "89abcdef"});

/// 6 contexts of point formats 6 to 10.
inline constexpr auto kReturnContexts6 =
    table_of<16>({"0123453445555555", "1013333333333333", "2124444444433333", "3345444444444444",
                  "4344544444444444", "5344454444444444", "3344445444444444", "4344444544444444",
                  "4344444454444444", "5344444445444444", "5344444444544444", "5334444444455444",
                  "5334444444455544", "5334444444445554", "5334444444444555", "5334444444444455"});

/// How many returns lie behind this one; at most 7. Context of heights.
constexpr unsigned return_level(unsigned returns, unsigned return_number) {
  const unsigned level =
      returns > return_number ? returns - return_number : return_number - returns;
  return std::min(level, 7U);
}

/// Approximate median of the last values: five of them in order, of which a new one displaces the
/// largest or the smallest in turn.
class StreamingMedian {
 public:
  std::int32_t get() const { return ordered_[2]; }

  void add(std::int32_t value) {
    if (drops_largest_) {
      drops_largest_ = value < ordered_[2];
      for (std::size_t i = 0; i < 4; ++i) {
        const std::int32_t here = ordered_[i];
        ordered_[i] = std::min(here, value);
        value = std::max(here, value);
      }
      ordered_[4] = value;
    } else {
      drops_largest_ = value <= ordered_[2];
      for (std::size_t i = 4; i > 0; --i) {
        const std::int32_t here = ordered_[i];
        ordered_[i] = std::max(here, value);
        value = std::min(here, value);
      }
      ordered_[0] = value;
    }
  }

 private:
  std::array<std::int32_t, 5> ordered_{};
  bool drops_largest_ = true;
};

/// Context of y by the width of x, and of z by the widths of both: pairs of widths together.
constexpr unsigned width_context(unsigned width, unsigned widest, bool single_return) {
  return (single_return ? 1U : 0U) + std::min(width & ~1U, widest);
}

}  // namespace orbweave::laz
