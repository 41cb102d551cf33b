// Red, green and blue among the attributes of vertices.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

#include "io/point_cloud.h"
#include "io/scalar_types.h"

namespace orbweave {

/// Where the attributes red, green and blue lie, of 8 or 16 bits each.
class VertexColors {
 public:
  /// The value of a channel and the largest value that it can have, 255 or 65535.
  struct Channel {
    std::uint16_t value = 0;
    std::uint16_t most = 255;
  };

  explicit VertexColors(const PointSchema& schema) : row_bytes_(schema.attribute_bytes()) {
    constexpr std::array<const char*, 3> kChannels = {"red", "green", "blue"};
    for (std::size_t c = 0; c < kChannels.size(); ++c) {
      std::size_t offset = 0;
      for (const AttributeField& field : schema.attributes) {
        const bool is_color = field.type == ScalarType::kUint8 || field.type == ScalarType::kUint16;
        if (is_color && field.name == kChannels[c]) {
          places_[c] = {offset, field.type == ScalarType::kUint16};
          ++found_;
          break;
        }
        offset += size_of(field.type);
      }
    }
  }

  bool all_are_there() const { return found_ == places_.size(); }

  /// Of a point that has the schema's attributes. Precondition: all are there.
  std::array<Channel, 3> of(const PointCloud& points, std::size_t i) const {
    std::array<Channel, 3> color{};
    for (std::size_t c = 0; c < color.size(); ++c) {
      const Place& place = places_[c];
      const std::byte* const at = points.attributes.data() + i * row_bytes_ + place.offset;
      std::memcpy(&color[c].value, at, place.is_wide ? 2 : 1);
      if (place.is_wide) color[c].most = 65535;
    }
    return color;
  }

 private:
  struct Place {
    std::size_t offset = 0;
    bool is_wide = false;
  };

  std::size_t row_bytes_;
  std::array<Place, 3> places_;
  std::size_t found_ = 0;
};

/// Whether an attribute of that name is a channel of a colour.
inline bool is_color_channel(const AttributeField& field) {
  return field.name == "red" || field.name == "green" || field.name == "blue";
}

}  // namespace orbweave
