#include "io/point_cloud.h"

#include <algorithm>
#include <cstring>

namespace orbweave {
namespace {

template <class T>
double as_double(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

}  // namespace

std::size_t PointSchema::attribute_bytes() const {
  std::size_t bytes = 0;
  for (const AttributeField& field : attributes) bytes += size_of(field.type);
  return bytes;
}

void PointCloud::clear() {
  positions.clear();
  normals.clear();
  attributes.clear();
}

void PointCloud::reserve(std::size_t points) {
  positions.reserve(points);
  if (schema.has_normals) normals.reserve(points);
  attributes.reserve(points * schema.attribute_bytes());
}

std::span<const std::byte> PointCloud::attribute_row(std::size_t i) const {
  const std::size_t bytes = schema.attribute_bytes();
  return std::span<const std::byte>(attributes).subspan(i * bytes, bytes);
}

void PointCloud::append(const PointCloud& other, std::size_t i) {
  positions.push_back(other.positions[i]);
  if (!other.normals.empty()) normals.push_back(other.normals[i]);
  const auto row = other.attribute_row(i);
  attributes.insert(attributes.end(), row.begin(), row.end());
}

void PointCloud::append(const PointCloud& other) {
  positions.insert(positions.end(), other.positions.begin(), other.positions.end());
  normals.insert(normals.end(), other.normals.begin(), other.normals.end());
  attributes.insert(attributes.end(), other.attributes.begin(), other.attributes.end());
}

PointCloud kept_points(PointCloud cloud, std::span<const std::uint8_t> kept) {
  const std::size_t points = cloud.size();
  const auto first_gone = std::find(kept.begin(), kept.end(), std::uint8_t{0});
  const auto begin = std::min(points, static_cast<std::size_t>(first_gone - kept.begin()));
  // Column after column, in the order of memory; points only move to the front.
  const auto close_up = [&](std::vector<Vec3>& values) {
    if (values.empty()) return;
    std::size_t to = begin;
    for (std::size_t i = begin; i < points; ++i)
      if (kept[i] != 0) values[to++] = values[i];
    values.resize(to);
  };
  close_up(cloud.positions);
  close_up(cloud.normals);
  const std::size_t bytes = cloud.schema.attribute_bytes();
  if (bytes == 0) return cloud;
  std::byte* const rows = cloud.attributes.data();
  std::byte* to = rows + begin * bytes;
  for (std::size_t first = begin, last = begin; first < points; first = last + 1) {
    for (last = first; last < points && kept[last] != 0;) ++last;
    to = std::copy(rows + first * bytes, rows + last * bytes, to);
  }
  cloud.attributes.resize(static_cast<std::size_t>(to - rows));
  return cloud;
}

Box PointCloud::bounds() const {
  Box box;
  for (const Vec3& p : positions) box.extend(p);
  return box;
}

double attribute_value(const PointCloud& cloud, std::size_t point, std::size_t field) {
  std::size_t offset = 0;
  for (std::size_t f = 0; f < field; ++f) offset += size_of(cloud.schema.attributes[f].type);
  const std::byte* at = cloud.attribute_row(point).data() + offset;
  double value = 0.0;
  visit_scalar(cloud.schema.attributes[field].type,
               [&](auto kind) { value = as_double<decltype(kind)>(at); });
  return value;
}

}  // namespace orbweave
