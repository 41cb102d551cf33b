#include "engine/holes/patch/patch_vertices.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "io/scalar_types.h"

namespace orbweave {
namespace {

template <class T>
void put(double value, std::byte* out) {
  T stored{};
  if constexpr (std::is_floating_point_v<T>) {
    stored = static_cast<T>(value);
  } else {
    // The largest 64-bit values are no doubles: what rounds up to them would not fit.
    const double least = static_cast<double>(std::numeric_limits<T>::min());
    const double most = static_cast<double>(std::numeric_limits<T>::max());
    const double whole = std::round(value);
    stored = !(whole > least)  ? std::numeric_limits<T>::min()
             : !(whole < most) ? std::numeric_limits<T>::max()
                               : static_cast<T>(whole);
  }
  std::memcpy(out, &stored, sizeof stored);
}

void put_as(ScalarType type, double value, std::byte* out) {
  visit_scalar(type, [&](auto kind) { put<decltype(kind)>(value, out); });
}

}  // namespace

PointCloud patch_vertices(const PointSchema& schema, std::span<const Vec3> positions,
                          std::span<const Vec3> normals, std::span<const double> values) {
  PointCloud cloud;
  cloud.schema = schema;
  cloud.positions.assign(positions.begin(), positions.end());
  if (schema.has_normals) cloud.normals.assign(normals.begin(), normals.end());
  cloud.attributes.resize(positions.size() * schema.attribute_bytes());
  std::byte* out = cloud.attributes.data();
  const std::size_t fields = schema.attributes.size();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t f = 0; f < fields; ++f) {
      put_as(schema.attributes[f].type, values[i * fields + f], out);
      out += size_of(schema.attributes[f].type);
    }
  }
  return cloud;
}

std::vector<double> attribute_values(const PointCloud& cloud, std::span<const std::uint64_t> rows) {
  const std::size_t fields = cloud.schema.attributes.size();
  const std::size_t row_bytes = cloud.schema.attribute_bytes();
  std::vector<double> values(rows.size() * fields);
  std::size_t offset = 0;
  for (std::size_t f = 0; f < fields; ++f) {
    const ScalarType type = cloud.schema.attributes[f].type;
    visit_scalar(type, [&](auto kind) {
      for (std::size_t i = 0; i < rows.size(); ++i) {
        std::memcpy(&kind, cloud.attributes.data() + rows[i] * row_bytes + offset, sizeof kind);
        values[i * fields + f] = static_cast<double>(kind);
      }
    });
    offset += size_of(type);
  }
  return values;
}

}  // namespace orbweave
