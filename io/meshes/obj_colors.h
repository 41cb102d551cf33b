// Colours of the vertices of OBJ files.
#pragma once

#include <array>
#include <cstdint>

#include "io/meshes/vertex_colors.h"

namespace orbweave {

/// Red, green and blue of a vertex, from 0 to 1: what most programs read behind its coordinates,
/// though the format itself has no place for them.
class ObjColors {
 public:
  explicit ObjColors(const PointSchema& schema) : colors_(schema) {}

  bool all_are_there() const { return colors_.all_are_there(); }

  /// Of a point that has the schema's attributes.
  std::array<double, 3> of(const PointCloud& points, std::size_t i) const {
    std::array<double, 3> color{};
    const std::array<VertexColors::Channel, 3> channels = colors_.of(points, i);
    for (std::size_t c = 0; c < color.size(); ++c) {
      constexpr std::uint64_t kStepsOfBytes = 10'000;
      constexpr std::uint64_t kStepsOfWords = 10'000'000;
      const VertexColors::Channel& channel = channels[c];
      color[c] = fraction(channel.value, channel.most,
                          channel.most == 255 ? kStepsOfBytes : kStepsOfWords);
    }
    return color;
  }

 private:
  /// The decimal just above the value: programs that cut digits off find the same integer as those
  /// that round.
  static double fraction(std::uint32_t value, std::uint32_t most, std::uint64_t steps) {
    if (value == 0 || value == most) return value == 0 ? 0.0 : 1.0;
    const std::uint64_t whole_steps = value * steps / most;
    return static_cast<double>(whole_steps + 1) / static_cast<double>(steps);
  }

  VertexColors colors_;
};

}  // namespace orbweave
