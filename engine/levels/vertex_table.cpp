#include "engine/levels/vertex_table.h"

#include <array>
#include <cstring>
#include <string_view>

#include "io/scalar_types.h"

namespace orbweave {
namespace {

using FloatVector = std::array<float, 3>;

FloatVector floats_of(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace

Vec3 position_of_row(const std::byte* row) {
  Vec3 position;
  std::memcpy(&position, row, sizeof position);
  return position;
}

VertexTable::VertexTable(const std::filesystem::path& directory, const PointSchema& schema)
    : values_(vertex_values(schema)), ranges_(schema), file_(directory) {
  schema_.has_normals = schema.has_normals;
  for (const std::string_view channel : {"red", "green", "blue"}) {
    std::size_t offset = 0;
    for (const AttributeField& field : schema.attributes) {
      const bool is_color = field.type == ScalarType::kUint8 || field.type == ScalarType::kUint16;
      if (is_color && field.name == channel) {
        schema_.attributes.push_back(field);
        kept_.push_back({offset, size_of(field.type)});
        break;
      }
      offset += size_of(field.type);
    }
  }
  if (kept_.size() < 3) {
    kept_.clear();
    schema_.attributes.clear();
  }
  for (const VertexValue& value : values_)
    schema_.attributes.push_back({value.name, ScalarType::kFloat32});
  row_bytes_ =
      sizeof(Vec3) + (schema_.has_normals ? sizeof(FloatVector) : 0) + schema_.attribute_bytes();
}

void VertexTable::append(const PointCloud& vertices) {
  std::vector<std::byte> rows(vertices.size() * row_bytes_);
  std::byte* at = rows.data();
  const std::size_t attribute_bytes = vertices.schema.attribute_bytes();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vec3 position = vertices.positions[i];
    if (is_finite(position)) bounds_.extend(position);
    std::memcpy(at, &position, sizeof position);
    at += sizeof position;
    if (schema_.has_normals) {
      const FloatVector normal = floats_of(vertices.normals[i]);
      std::memcpy(at, normal.data(), sizeof normal);
      at += sizeof normal;
    }
    for (const Kept& kept : kept_) {
      std::memcpy(at, vertices.attributes.data() + i * attribute_bytes + kept.offset, kept.bytes);
      at += kept.bytes;
    }
    for (const VertexValue& value : values_) {
      const float number = value_at(value, vertices.attributes.data() + i * attribute_bytes);
      std::memcpy(at, &number, sizeof number);
      at += sizeof number;
    }
  }
  ranges_.add(vertices.attributes);
  checksum_.add(rows.data(), rows.size());
  file_.append(rows);
  vertices_ += vertices.size();
}

std::vector<std::byte> VertexTable::rows(std::span<const std::uint64_t> numbers) const {
  // Vertices that lie close together are read at once, with what lies between them.
  constexpr std::uint64_t kWidestGap = 64;
  constexpr std::uint64_t kMostRows = 4096;
  std::vector<std::byte> rows(numbers.size() * row_bytes_);
  std::vector<std::byte> run;
  for (std::size_t begin = 0; begin < numbers.size();) {
    std::size_t end = begin + 1;
    while (end < numbers.size() && numbers[end] - numbers[end - 1] <= kWidestGap &&
           numbers[end] - numbers[begin] < kMostRows)
      ++end;
    run.resize((numbers[end - 1] - numbers[begin] + 1) * row_bytes_);
    file_.read(numbers[begin] * row_bytes_, run);
    for (std::size_t i = begin; i < end; ++i)
      std::memcpy(rows.data() + i * row_bytes_,
                  run.data() + (numbers[i] - numbers[begin]) * row_bytes_, row_bytes_);
    begin = end;
  }
  return rows;
}

PointCloud VertexTable::points(std::span<const std::byte> rows) const {
  PointCloud points;
  points.schema = schema_;
  const std::size_t count = rows.size() / row_bytes_;
  points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::byte* at = rows.data() + i * row_bytes_;
    points.positions.push_back(position_of_row(at));
    at += sizeof(Vec3);
    if (schema_.has_normals) {
      FloatVector normal;
      std::memcpy(normal.data(), at, sizeof normal);
      points.normals.push_back({normal[0], normal[1], normal[2]});
      at += sizeof normal;
    }
    points.attributes.insert(points.attributes.end(), at, at + schema_.attribute_bytes());
  }
  return points;
}

}  // namespace orbweave
