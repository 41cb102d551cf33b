#include "io/vertex_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "io/scalar_types.h"

namespace orbweave {
namespace {

constexpr const char* kConfidence = "vertex_confidence";
constexpr const char* kUndersampled = "undersampled";

/// Of meshes and of tiles.
struct Names {
  const char* of_mesh;
  const char* of_tile;
};
constexpr std::array<Names, 5> kNames = {{{"confidence", kConfidence},
                                          {"quality_spacing", "quality_spacing"},
                                          {"quality_noise", "quality_noise"},
                                          {"quality_moved", "quality_moved"},
                                          {kUndersampled, kUndersampled}}};

double number_at(ScalarType type, const std::byte* at) {
  double number = 0.0;
  visit_scalar(type, [&](auto value) {
    std::memcpy(&value, at, sizeof value);
    number = static_cast<double>(value);
  });
  return number;
}

}  // namespace

std::vector<VertexValue> vertex_values(const PointSchema& schema) {
  std::vector<VertexValue> values;
  for (const Names& names : kNames) {
    std::size_t offset = 0;
    for (const AttributeField& field : schema.attributes) {
      if (field.name == names.of_mesh || field.name == names.of_tile) {
        values.push_back({names.of_tile, offset, field.type});
        break;
      }
      offset += size_of(field.type);
    }
  }
  return values;
}

float value_at(const VertexValue& value, const std::byte* row) {
  constexpr float kUnknown = -1.0F;
  const double number = number_at(value.type, row + value.offset);
  const bool is_known =
      std::isfinite(number) && number >= 0.0 && (value.name != kUndersampled || number <= 1.0);
  const auto narrow = static_cast<float>(number);
  return is_known && std::isfinite(narrow) ? narrow : kUnknown;
}

ShownRanges::ShownRanges(const PointSchema& schema)
    : values_(vertex_values(schema)), sums_(values_.size()), row_bytes_(schema.attribute_bytes()) {}

void ShownRanges::add(std::span<const std::byte> rows) {
  if (values_.empty()) return;
  for (std::size_t at = 0; at < rows.size(); at += row_bytes_)
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double value = value_at(values_[i], rows.data() + at);
      if (value < 0.0) continue;
      Sums& sums = sums_[i];
      sums.least = sums.count == 0 ? value : std::min(sums.least, value);
      sums.most = std::max(sums.most, value);
      sums.sum += value;
      ++sums.count;
    }
}

std::vector<ShownRange> ShownRanges::ranges() const {
  std::vector<ShownRange> ranges;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const Sums& sums = sums_[i];
    if (sums.count == 0) continue;
    ShownRange range{values_[i].name, 0.0, 1.0};
    if (range.name == kConfidence) {
      range = {range.name, sums.least, sums.most};
    } else if (range.name != kUndersampled) {
      constexpr double kOfMean = 3.0;
      range.high = std::min(sums.most, kOfMean * sums.sum / static_cast<double>(sums.count));
    }
    if (range.high > range.low) ranges.push_back(range);
  }
  return ranges;
}

}  // namespace orbweave
