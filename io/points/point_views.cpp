#include "io/points/point_views.h"

#include <cmath>
#include <cstring>
#include <utility>

namespace orbweave {
namespace {

constexpr double kViewScale = 32767.0;

double sign_of(double value) { return value < 0.0 ? -1.0 : 1.0; }

}  // namespace

const std::vector<AttributeField>& view_fields() {
  static const std::vector<AttributeField> fields = {{"orbweave view u", ScalarType::kInt16},
                                                     {"orbweave view v", ScalarType::kInt16}};
  return fields;
}

ViewCode encode_view(Vec3 d) {
  const double sum = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
  if (!(sum > 0.0) || !std::isfinite(sum)) return {};
  double u = d.x / sum;
  double v = d.y / sum;
  if (d.z < 0.0) {
    const double folded = (1.0 - std::abs(v)) * sign_of(u);
    v = (1.0 - std::abs(u)) * sign_of(v);
    u = folded;
  }
  const auto code = [](double value) {
    return static_cast<std::int16_t>(std::lround(value * kViewScale));
  };
  return {code(u), code(v)};
}

Vec3 decode_view(ViewCode code) {
  Vec3 d{code.u / kViewScale, code.v / kViewScale, 0.0};
  d.z = 1.0 - std::abs(d.x) - std::abs(d.y);
  if (d.z < 0.0) {
    const double x = (1.0 - std::abs(d.y)) * sign_of(d.x);
    d.y = (1.0 - std::abs(d.x)) * sign_of(d.y);
    d.x = x;
  }
  return normalized(d);
}

std::optional<std::size_t> view_offset(const PointSchema& schema) {
  const std::size_t count = schema.attributes.size();
  if (count < 2 || schema.attributes[count - 2] != view_fields()[0]) return std::nullopt;
  return schema.attribute_bytes() - sizeof(ViewCode);
}

PointSchema without_view(PointSchema schema) {
  if (view_offset(schema)) schema.attributes.resize(schema.attributes.size() - 2);
  return schema;
}

void add_views(std::span<const ViewCode> views, PointCloud& cloud) {
  const std::size_t from_bytes = cloud.schema.attribute_bytes();
  cloud.schema.attributes.insert(cloud.schema.attributes.end(), view_fields().begin(),
                                 view_fields().end());
  const std::size_t row_bytes = cloud.schema.attribute_bytes();
  cloud.attributes.resize(cloud.size() * row_bytes);
  // Rows only move towards the end, so each is still whole when its turn comes, from the last on.
  for (std::size_t i = cloud.size(); i-- > 0;) {
    std::byte* const row = cloud.attributes.data() + i * row_bytes;
    if (from_bytes != 0) std::memmove(row, cloud.attributes.data() + i * from_bytes, from_bytes);
    std::memcpy(row + from_bytes, &views[i], sizeof(ViewCode));
  }
}

void drop_views(PointCloud& cloud) {
  const std::size_t from_bytes = cloud.schema.attribute_bytes();
  cloud.schema = without_view(std::move(cloud.schema));
  const std::size_t to_bytes = cloud.schema.attribute_bytes();
  if (from_bytes == to_bytes) return;
  // Rows only move towards the front, so each is still whole when its turn comes.
  for (std::size_t i = 0; i < cloud.size() && to_bytes != 0; ++i)
    std::memmove(cloud.attributes.data() + i * to_bytes, cloud.attributes.data() + i * from_bytes,
                 to_bytes);
  cloud.attributes.resize(cloud.size() * to_bytes);
}

ViewCode view_of(const PointCloud& cloud, std::size_t point, std::size_t offset) {
  ViewCode code;
  std::memcpy(&code, cloud.attribute_row(point).data() + offset, sizeof code);
  return code;
}

Vec3 direction_to_scanner(const PointCloud& cloud, std::size_t point, std::size_t offset) {
  const ViewCode code = view_of(cloud, point, offset);
  return code.known() ? decode_view(code) : Vec3{};
}

std::uint64_t count_without_view(const PointCloud& cloud) {
  const std::optional<std::size_t> offset = view_offset(cloud.schema);
  if (!offset) return cloud.size();
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    count += view_of(cloud, i, *offset).known() ? 0 : 1;
  return count;
}

}  // namespace orbweave
