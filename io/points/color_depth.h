// Colours of vertices at the width that other programs show: red, green and blue of 8 bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "io/point_cloud.h"

namespace orbweave {

/// Where the attributes red, green and blue lie in a row, all of 16 bits. Names in any case.
struct WideColors {
  std::size_t fields[3] = {};   ///< numbers of the attributes
  std::size_t offsets[3] = {};  ///< bytes from the row's front
};
/// Nothing where not all three are there as 16-bit numbers.
std::optional<WideColors> wide_colors(const PointSchema& schema);

/// Whether any colour of the points is beyond 255. A scan whose colours all are below has 8-bit
/// colours in 16-bit fields: that is decided over all of its points, whatever their order.
bool exceed_8_bits(const PointCloud& points, const WideColors& colors);

/// Whether a file has colours of 8 bits where the common schema of several files has 16-bit ones.
bool widens_colors(const PointSchema& file, const PointSchema& common);
/// The 16-bit value of a colour of 8 bits: 255 is 65535.
std::uint16_t widened_color(std::uint8_t value);

/// Turns points as they were read into points as they are written.
class ColorDepth {
 public:
  ColorDepth() = default;
  /// `bits`: most bits of a channel, 8 or 16. `exceeds_8_bits`: of all points.
  ColorDepth(const PointSchema& read, int bits, bool exceeds_8_bits);

  /// 8-bit colours have the names red, green and blue; all else stays.
  const PointSchema& written() const { return written_; }
  bool changes() const { return colors_.has_value(); }
  /// Values 0..65535 become 0..255, rounded; values that never exceed 255 stay. Thread-safe.
  /// Precondition: the points have the schema that was read.
  void apply(PointCloud& points) const;

 private:
  /// Bytes of a row that stay.
  struct Run {
    std::size_t from = 0;
    std::size_t to = 0;
    std::size_t bytes = 0;
  };
  /// Before, between and behind three colours.
  struct Runs {
    std::array<Run, 4> at{};
    std::size_t count = 0;
  };

  PointSchema written_;
  std::optional<WideColors> colors_;
  std::array<std::size_t, 3> written_offsets_{};
  Runs runs_;
  std::size_t read_bytes_ = 0;
  bool scales_ = false;
};

}  // namespace orbweave
