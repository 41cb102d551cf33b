#include "engine/holes/loops/hole_choice.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "engine/holes/loops/open_scenes.h"

namespace orbweave {
namespace {

/// Loops in a surface agree by nearly 1, borders of a sheet by nearly -1.
constexpr double kOpposes = -0.5;
constexpr double kAgrees = 0.25;
constexpr double kLargeInPiece = 0.5;

std::string shown(double value) {
  std::array<char, 40> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 6)
          .ptr;
  return {text.data(), end};
}

double diagonal_of_pieces(const BoundaryLoop& loop, std::span<const Piece> pieces) {
  double largest = 0.0;
  for (const std::uint64_t piece : loop.components) {
    largest = std::max(largest, pieces[piece].box.diagonal());
  }
  return largest;
}

bool is_outer_border(const BoundaryLoop& loop, std::span<const Piece> pieces) {
  const double agreement = loop.agreement();
  if (agreement < kOpposes) return true;
  if (agreement > kAgrees) return false;
  return 2.0 * loop.radius >= kLargeInPiece * diagonal_of_pieces(loop, pieces);
}

/// Beyond this many spacings from side to side the surface around a gap says nothing of its middle.
constexpr double kWide = 48.0;

bool is_of_scene(const BoundaryLoop& loop, std::span<const std::uint8_t> is_scene) {
  return std::any_of(loop.components.begin(), loop.components.end(),
                     [&](std::uint64_t piece) { return is_scene[piece] != 0; });
}

bool is_too_wide(const BoundaryLoop& loop, std::span<const std::uint8_t> is_scene) {
  return loop_width(loop) > kWide * loop_spacing(loop) && is_of_scene(loop, is_scene);
}

HoleChoice too_wide(const BoundaryLoop& loop) {
  return {OpenReason::kTooWide,
          "a width of " + shown(loop_width(loop)) + ", " +
              shown(std::floor(loop_width(loop) / loop_spacing(loop))) +
              " times the length of its edges, in an open scene (fill.max_diameter)"};
}

/// What limits say.
HoleChoice choice_of(const BoundaryLoop& loop, const FillOptions& options) {
  if (options.max_edges > 0 && loop.vertices.size() > options.max_edges) {
    return {OpenReason::kMaxEdges,
            std::to_string(loop.vertices.size()) +
                " edges are more than fill.max_edges = " + std::to_string(options.max_edges)};
  }
  if (options.max_diameter && 2.0 * loop.radius > *options.max_diameter) {
    return {OpenReason::kMaxDiameter,
            "a diameter of " + shown(2.0 * loop.radius) +
                " is more than fill.max_diameter = " + shown(*options.max_diameter)};
  }
  if (loop.perimeter > options.max_perimeter) {
    return {OpenReason::kMaxPerimeter,
            "a perimeter of " + shown(loop.perimeter) +
                " is more than fill.max_perimeter = " + shown(options.max_perimeter)};
  }
  return {};
}

}  // namespace

std::uint64_t least_triangles(const FillOptions& options, std::uint64_t largest) {
  constexpr std::uint64_t kSurface = 1000, kCrumb = 16;
  return options.min_triangles.value_or(largest >= kSurface ? kCrumb : 0);
}

bool limits_widths(const FillOptions& options) {
  return options.keep_outer_border && !options.max_diameter;
}

std::vector<std::uint8_t> outer_borders(std::span<const BoundaryLoop> loops,
                                        std::span<const Piece> pieces) {
  std::vector<std::uint8_t> is_border;
  is_border.reserve(loops.size());
  for (const BoundaryLoop& loop : loops) is_border.push_back(is_outer_border(loop, pieces) ? 1 : 0);
  return is_border;
}

std::vector<HoleChoice> choose_holes(std::span<const BoundaryLoop> loops,
                                     std::span<const Piece> pieces, const FillOptions& options) {
  const std::vector<std::uint8_t> is_border = outer_borders(loops, pieces);
  const std::vector<std::uint8_t> is_scene = pieces_of_scenes(loops, pieces, is_border);
  const bool is_limited = limits_widths(options);
  std::vector<HoleChoice> choices;
  choices.reserve(loops.size());
  for (std::size_t l = 0; l < loops.size(); ++l) {
    const BoundaryLoop& loop = loops[l];
    HoleChoice& choice = choices.emplace_back(choice_of(loop, options));
    if (choice.open == OpenReason::kNone && options.keep_outer_border && is_border[l] != 0 &&
        is_of_scene(loop, is_scene))
      choice = {OpenReason::kOuterBorder,
                "the outer border of an open sheet (fill.keep_outer_border)"};
    if (choice.open == OpenReason::kNone && is_limited && is_too_wide(loop, is_scene))
      choice = too_wide(loop);
    choice.opposes_normals = loop.agreement() < kOpposes;
  }
  return choices;
}

}  // namespace orbweave
