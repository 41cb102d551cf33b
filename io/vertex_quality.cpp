#include "io/vertex_quality.h"

#include <algorithm>
#include <cstring>

namespace orbweave {

const std::vector<AttributeField>& quality_fields() {
  static const std::vector<AttributeField> fields = {{"quality_spacing", ScalarType::kFloat32},
                                                     {"quality_noise", ScalarType::kFloat32},
                                                     {"quality_moved", ScalarType::kFloat32},
                                                     {"quality_normal", ScalarType::kUint8}};
  return fields;
}

std::optional<std::size_t> quality_offset(const PointSchema& schema) {
  const std::vector<AttributeField>& all = schema.attributes;
  const std::vector<AttributeField>& wanted = quality_fields();
  const auto found = std::search(all.begin(), all.end(), wanted.begin(), wanted.end());
  if (found == all.end()) return std::nullopt;
  std::size_t offset = 0;
  for (auto field = all.begin(); field != found; ++field) offset += size_of(field->type);
  return offset;
}

void put_quality(const VertexQuality& quality, std::byte* at) {
  for (const float value : {quality.spacing, quality.noise, quality.moved}) {
    std::memcpy(at, &value, sizeof value);
    at += sizeof value;
  }
  *at = static_cast<std::byte>(quality.normal);
}

VertexQuality quality_at(const std::byte* at) {
  VertexQuality quality;
  for (float* value : {&quality.spacing, &quality.noise, &quality.moved}) {
    std::memcpy(value, at, sizeof *value);
    at += sizeof *value;
  }
  quality.normal = static_cast<NormalOrigin>(*at);
  return quality;
}

void mark_invented(const PointSchema& schema, std::span<double> values) {
  const std::vector<AttributeField>& all = schema.attributes;
  const std::vector<AttributeField>& wanted = quality_fields();
  const auto found = std::search(all.begin(), all.end(), wanted.begin(), wanted.end());
  if (found == all.end()) return;
  const auto first = static_cast<std::size_t>(found - all.begin());
  for (std::size_t row = first; row < values.size(); row += all.size()) {
    std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(row), wanted.size() - 1, -1.0);
    values[row + wanted.size() - 1] = static_cast<double>(NormalOrigin::kInvented);
  }
}

}  // namespace orbweave
