#include "io/report/picture_palette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr std::array<Rgb, kNamedComponents> kPalette = {{{0xe6, 0xc0, 0x6a},
                                                         {0x6f, 0xa8, 0xe0},
                                                         {0x7f, 0xc6, 0x6c},
                                                         {0xb8, 0x88, 0xd8},
                                                         {0x4f, 0xc4, 0xbc},
                                                         {0xee, 0x96, 0xba},
                                                         {0xac, 0xb4, 0x46},
                                                         {0xa2, 0x80, 0x60},
                                                         {0x8c, 0x92, 0xb4},
                                                         {0xf4, 0x9c, 0x58}}};

/// A pale colour of the hue, which runs from 0 to 1 around the circle.
Rgb pale(double hue) {
  constexpr double kDarkest = 150.0, kLightest = 235.0;
  Rgb colour{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double around = hue + static_cast<double>(c) / 3.0;
    const double away = std::abs(around - std::floor(around) - 0.5);  // 0.5 where it is lightest
    const double light = std::clamp(6.0 * away - 1.0, 0.0, 1.0);
    colour[c] = static_cast<std::uint8_t>(std::lround(kDarkest + light * (kLightest - kDarkest)));
  }
  return colour;
}

}  // namespace

Rgb component_color(std::size_t rank) {
  if (rank < kPalette.size()) return kPalette[rank];
  constexpr double kGoldenShare = 0.6180339887498949;  // neighbours in rank get hues far apart
  const double turns = static_cast<double>(rank) * kGoldenShare;
  return pale(turns - std::floor(turns));
}

std::vector<LegendEntry> component_legend(std::span<const std::uint64_t> triangles) {
  std::vector<LegendEntry> entries;
  const std::size_t named = std::min(triangles.size(), kNamedComponents);
  for (std::size_t rank = 0; rank < named; ++rank)
    entries.push_back({component_color(rank), component_color(rank),
                       "component of " + format_count(triangles[rank]) +
                           (triangles[rank] == 1 ? " triangle" : " triangles")});
  if (const std::size_t others = triangles.size() - named; others > 0)
    entries.push_back({component_color(named), component_color(named + 1),
                       format_count(others) +
                           (others == 1 ? " smaller component" : " smaller components") +
                           " in paler colours"});
  return entries;
}

}  // namespace orbweave
