#include "io/report/picture_legend.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "io/report/small_font.h"

namespace orbweave {
namespace {

constexpr Rgb kPaper{255, 255, 255}, kInk{40, 40, 48};
constexpr double kCover = 0.85;  // of what lies behind the legend

/// The legend in dots of the font; a dot is a square of pixels.
struct Layout {
  static constexpr int kMargin = 4;  // around the legend, and inside it
  static constexpr int kSwatch = 18;
  static constexpr int kPitch = kGlyphHeight + 3;
  static constexpr int kLetter = kGlyphWidth + 1;

  Layout(const std::vector<LegendEntry>& entries, int width, int height)
      : dot(std::max(1, height / 450)) {
    const int room = height / dot - 4 * kMargin;
    lines = std::clamp(room / kPitch, 0, static_cast<int>(entries.size()));
    std::size_t longest = 0;
    for (int i = 0; i < lines; ++i)
      longest = std::max(longest, entries[static_cast<std::size_t>(i)].text.size());
    const int most = (width / dot - 5 * kMargin - kSwatch) / kLetter;
    letters = std::clamp(static_cast<int>(longest), 0, std::max(most, 0));
    if (most < 1) lines = 0;
  }

  int dot = 1;  ///< pixels
  int lines = 0;
  int letters = 0;  ///< of the longest line
};

/// Paints squares of dots, from dots to pixels.
class DotPainter {
 public:
  DotPainter(int dot, int width, int height, std::vector<std::uint8_t>& pixels)
      : dot_(dot), width_(width), height_(height), pixels_(pixels) {}

  void paint(int x, int y, const Rgb& colour, double cover = 1.0) {
    for (int row = dot_ * y; row < std::min(dot_ * (y + 1), height_); ++row)
      for (int column = dot_ * x; column < std::min(dot_ * (x + 1), width_); ++column)
        mix(row, column, colour, cover);
  }

 private:
  void mix(int row, int column, const Rgb& colour, double cover) {
    const std::size_t at = 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) +
                                static_cast<std::size_t>(column));
    for (std::size_t c = 0; c < 3; ++c) {
      const double mixed = cover * colour[c] + (1.0 - cover) * pixels_[at + c];
      pixels_[at + c] = static_cast<std::uint8_t>(std::lround(mixed));
    }
  }

  int dot_, width_, height_;
  std::vector<std::uint8_t>& pixels_;
};

Rgb between(const LegendEntry& entry, double share) {
  Rgb colour{};
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = static_cast<std::uint8_t>(std::lround(
        entry.first[c] + share * (static_cast<double>(entry.last[c]) - entry.first[c])));
  return colour;
}

void draw_swatch(const LegendEntry& entry, int left, int top, DotPainter& painter) {
  for (int x = 0; x < Layout::kSwatch; ++x) {
    const Rgb colour = between(entry, x / (Layout::kSwatch - 1.0));
    for (int y = 0; y < kGlyphHeight - 1; ++y) painter.paint(left + x, top + y, colour);
  }
}

void draw_text(const std::string& text, int letters, int left, int top, DotPainter& painter) {
  const int drawn = std::min(letters, static_cast<int>(text.size()));
  for (int i = 0; i < drawn; ++i)
    for (int y = 0; y < kGlyphHeight; ++y)
      for (int x = 0; x < kGlyphWidth; ++x)
        if (has_ink(text[static_cast<std::size_t>(i)], x, y))
          painter.paint(left + i * Layout::kLetter + x, top + y, kInk);
}

}  // namespace

void draw_legend(const std::vector<LegendEntry>& entries, int width, int height,
                 std::vector<std::uint8_t>& pixels) {
  const Layout layout(entries, width, height);
  if (layout.lines == 0) return;
  constexpr int kMargin = Layout::kMargin;
  DotPainter painter(layout.dot, width, height, pixels);
  const int right = 4 * kMargin + Layout::kSwatch + layout.letters * Layout::kLetter;
  const int bottom = 3 * kMargin + layout.lines * Layout::kPitch - (Layout::kPitch - kGlyphHeight);
  for (int y = kMargin; y < bottom; ++y)
    for (int x = kMargin; x < right; ++x) painter.paint(x, y, kPaper, kCover);
  for (int i = 0; i < layout.lines; ++i) {
    const LegendEntry& entry = entries[static_cast<std::size_t>(i)];
    const int top = 2 * kMargin + i * Layout::kPitch;
    draw_swatch(entry, 2 * kMargin, top, painter);
    draw_text(entry.text, layout.letters, 3 * kMargin + Layout::kSwatch, top, painter);
  }
}

}  // namespace orbweave
