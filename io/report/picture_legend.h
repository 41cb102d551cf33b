// Words in a picture: what its colours mean.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace orbweave {

using Rgb = std::array<std::uint8_t, 3>;  ///< red, green, blue

/// A line of the legend: a swatch that runs from one colour to another, and what it means.
struct LegendEntry {
  Rgb first{};
  Rgb last{};  ///< the same as `first` for a colour that stands alone
  std::string text;
};

/// Draws the lines into the upper left corner of a picture of 3 bytes per pixel, row by row from
/// the top; what lies behind shines through a little. Lines that find no room are left out.
void draw_legend(const std::vector<LegendEntry>& entries, int width, int height,
                 std::vector<std::uint8_t>& pixels);

}  // namespace orbweave
