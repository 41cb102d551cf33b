// Colours of the vertices of OBJ files.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

#include "io/point_cloud.h"
#include "io/scalar_types.h"

namespace orbweave {

/// Red, green and blue of a vertex, from 0 to 1: what most programs read behind its coordinates,
/// though the format itself has no place for them.
class ObjColors {
 public:
  explicit ObjColors(const PointSchema& schema) : row_bytes_(schema.attribute_bytes()) {
    constexpr std::array<const char*, 3> kChannels = {"red", "green", "blue"};
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      std::size_t offset = 0;
      for (const AttributeField& field : schema.attributes) {
        const bool is_color = field.type == ScalarType::kUint8 || field.type == ScalarType::kUint16;
        if (is_color && field.name == kChannels[c]) {
          channels_[c] = {offset, field.type == ScalarType::kUint16};
          ++found_;
          break;
        }
        offset += size_of(field.type);
      }
    }
  }

  bool all_are_there() const { return found_ == channels_.size(); }

  /// Of a point that has the schema's attributes.
  std::array<double, 3> of(const PointCloud& points, std::size_t i) const {
    std::array<double, 3> color{};
    for (std::size_t c = 0; c < color.size(); ++c) {
      const Channel& channel = channels_[c];
      const std::byte* const at = points.attributes.data() + i * row_bytes_ + channel.offset;
      std::uint16_t value = 0;
      std::memcpy(&value, at, channel.is_wide ? 2 : 1);
      color[c] =
          channel.is_wide ? fraction(value, 65535, 10'000'000) : fraction(value, 255, 10'000);
    }
    return color;
  }

 private:
  struct Channel {
    std::size_t offset = 0;
    bool is_wide = false;
  };

  /// The decimal just above the value: programs that cut digits off find the same integer as those
  /// that round.
  static double fraction(std::uint32_t value, std::uint32_t most, std::uint64_t steps) {
    if (value == 0 || value == most) return value == 0 ? 0.0 : 1.0;
    const std::uint64_t whole_steps = value * steps / most;
    return static_cast<double>(whole_steps + 1) / static_cast<double>(steps);
  }

  std::size_t row_bytes_;
  std::array<Channel, 3> channels_;
  std::size_t found_ = 0;
};

}  // namespace orbweave
