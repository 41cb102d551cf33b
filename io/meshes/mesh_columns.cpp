#include "io/meshes/mesh_columns.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "io/text/distinct_names.h"

namespace orbweave {
namespace {

static_assert(std::endian::native == std::endian::little, "columns are written as they lie");

using Of = MeshColumn::Of;

constexpr const char* kColors = "RGB";

/// Red, green and blue by their places among the attributes, where they are of one width that
/// programs take for colours.
std::optional<std::array<std::size_t, 3>> color_fields(const PointSchema& schema) {
  std::array<std::size_t, 3> fields{};
  constexpr std::array<std::string_view, 3> kChannels = {"red", "green", "blue"};
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    const auto found = std::ranges::find(schema.attributes, kChannels[c], &AttributeField::name);
    if (found == schema.attributes.end()) return std::nullopt;
    if (found->type != ScalarType::kUint8 && found->type != ScalarType::kUint16)
      return std::nullopt;
    fields[c] = static_cast<std::size_t>(found - schema.attributes.begin());
    if (found->type != schema.attributes[fields[0]].type) return std::nullopt;
  }
  return fields;
}

/// A name that neither XML nor HDF5 takes for anything else.
std::string plain_name(const std::string& name) {
  std::string plain;
  for (const char c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                          (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
    plain += is_plain ? c : '_';
  }
  const bool is_path = plain.find_first_not_of('.') == std::string::npos;
  return is_path ? "_" + plain : plain;
}

template <class Real>
void put_vectors(std::span<const Vec3> vectors, Vec3 origin, std::byte* at) {
  for (const Vec3& vector : vectors) {
    const Vec3 v = vector - origin;
    const std::array<Real, 3> numbers = {static_cast<Real>(v.x), static_cast<Real>(v.y),
                                         static_cast<Real>(v.z)};
    std::memcpy(at, numbers.data(), sizeof numbers);
    at += sizeof numbers;
  }
}

void put_vectors(ScalarType type, std::span<const Vec3> vectors, Vec3 origin, std::byte* at) {
  if (type == ScalarType::kFloat32)
    put_vectors<float>(vectors, origin, at);
  else
    put_vectors<double>(vectors, origin, at);
}

}  // namespace

MeshColumns::MeshColumns(const MeshHeader& header, const MeshWriterOptions& options, bool has_ends)
    : origin_(options.origin), attribute_bytes_(header.schema.attribute_bytes()) {
  const ScalarType position = options.float_positions ? ScalarType::kFloat32 : ScalarType::kFloat64;
  vertices_.push_back({"Points", Of::kPoint, position, 3, header.vertices, {}});
  if (header.schema.has_normals)
    vertices_.push_back(
        {"Normals", Of::kNormal, header.schema.normal_type, 3, header.vertices, {}});
  add_attributes(header);
  triangles_.push_back({"connectivity", Of::kCorners, ScalarType::kInt64, 3, header.triangles, {}});
  if (has_ends)
    triangles_.push_back({"offsets", Of::kEnds, ScalarType::kInt64, 1, header.triangles, {}});
  if (header.has_hole)
    triangles_.push_back({"hole", Of::kHole, ScalarType::kInt32, 1, header.triangles, {}});
}

void MeshColumns::add_attributes(const MeshHeader& header) {
  const std::vector<AttributeField>& fields = header.schema.attributes;
  std::vector<std::size_t> offsets;
  std::size_t offset = 0;
  for (const AttributeField& field : fields) {
    offsets.push_back(offset);
    offset += size_of(field.type);
  }
  DistinctNames names({"Points", "Normals", "connectivity", "offsets", "hole"});
  const auto colors = color_fields(header.schema);
  if (colors) {
    const auto [red, green, blue] = *colors;
    vertices_.push_back({names.give(kColors),
                         Of::kColor,
                         fields[red].type,
                         3,
                         header.vertices,
                         {offsets[red], offsets[green], offsets[blue]}});
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (colors && std::ranges::find(*colors, i) != colors->end()) continue;
    vertices_.push_back({names.give(plain_name(fields[i].name)),
                         Of::kAttribute,
                         fields[i].type,
                         1,
                         header.vertices,
                         {offsets[i]}});
  }
}

std::vector<std::byte> MeshColumns::rows(const MeshColumn& column, const PointCloud& batch) const {
  std::vector<std::byte> bytes(batch.size() * column.row_bytes());
  if (column.of == Of::kPoint) put_vectors(column.type, batch.positions, origin_, bytes.data());
  if (column.of == Of::kNormal) put_vectors(column.type, batch.normals, {}, bytes.data());
  std::byte* at = bytes.data();
  const std::size_t width = size_of(column.type);
  for (std::size_t i = 0; !column.offsets.empty() && i < batch.size(); ++i)
    for (const std::size_t offset : column.offsets) {
      std::memcpy(at, batch.attributes.data() + i * attribute_bytes_ + offset, width);
      at += width;
    }
  return bytes;
}

std::vector<std::byte> MeshColumns::rows(const MeshColumn& column,
                                         std::span<const Triangle64> batch,
                                         std::span<const std::int32_t> hole,
                                         std::uint64_t first) const {
  const auto copied = [](auto values) {
    const auto bytes = std::as_bytes(values);
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  };
  if (column.of == Of::kHole) return copied(hole);
  if (column.of == Of::kCorners) return copied(batch);
  std::vector<std::int64_t> ends;
  ends.reserve(batch.size());
  for (std::size_t i = 0; i < batch.size(); ++i)
    ends.push_back(static_cast<std::int64_t>(3 * (first + i + 1)));
  return copied(std::span<const std::int64_t>(ends));
}

}  // namespace orbweave
