#include "io/clouds/las/las_layout.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "io/scalar_types.h"
#include "io/text/distinct_names.h"
#include "io/text/little_endian.h"
#include "io/text/lower_case.h"

namespace orbweave::las {
namespace {

/// Places of the fields that only some formats have, in bytes; 0: not there.
/// LAS Specification 1.4 R15, tables 7 to 20.
struct OptionalFields {
  std::uint8_t gps_time;
  std::uint8_t red;  ///< green and blue follow
  std::uint8_t nir;
};
constexpr std::array<OptionalFields, 11> kOptionalFields = {{{0, 0, 0},
                                                             {20, 0, 0},
                                                             {0, 20, 0},
                                                             {20, 28, 0},
                                                             {20, 0, 0},
                                                             {20, 28, 0},
                                                             {22, 0, 0},
                                                             {22, 30, 0},
                                                             {22, 30, 36},
                                                             {22, 0, 0},
                                                             {22, 30, 36}}};
constexpr std::size_t kIntensity = 12;
constexpr std::size_t kReturns = 14;
constexpr std::size_t kFlags = 15;  ///< with the class in formats 0 to 5
/// The first of the formats that LAS 1.4 brought, with more room for what there is more of.
constexpr std::uint8_t kFirstLongFormat = 6;

std::byte withheld_bit(const Header& header) {
  if (header.point_format >= kFirstLongFormat) return std::byte{1u << 2};
  // LAS 1.0 gives the upper bits of the class no meaning.
  return header.version_minor == 0 ? std::byte{0} : std::byte{1u << 7};
}

/// What a stored value means, as a double.
template <class T>
double meaning(const StoredValue& value, const std::byte* record) {
  const double stored = static_cast<double>(load_little<T>(record + value.offset));
  return value.is_scaled ? stored * value.scale + value.shift : stored;
}

ScalarType cloud_type(const StoredValue& value) {
  return value.is_scaled ? ScalarType::kFloat64 : value.type;
}

/// 0, 1, 2 for a component of a normal; 3 for anything else.
std::size_t normal_axis(const std::string& name) {
  constexpr std::array<std::array<std::string_view, 3>, 3> kNames = {
      {{"normalx", "nx", "normal_x"},
       {"normaly", "ny", "normal_y"},
       {"normalz", "nz", "normal_z"}}};
  const std::string plain = lower_case(name);
  std::size_t axis = 0;
  while (axis < 3 && std::ranges::find(kNames[axis], plain) == kNames[axis].end()) ++axis;
  return axis;
}

/// A name that every format can write: blanks and control characters do not survive in all.
std::string plain_name(std::string name) {
  const auto is_blank = [](char c) { return static_cast<unsigned char>(c) <= ' ' || c == '\x7f'; };
  std::replace_if(name.begin(), name.end(), is_blank, '_');
  return name.empty() ? "extra" : name;
}

}  // namespace

Layout::Layout(const Header& header, std::vector<StoredValue> extra)
    : record_bytes_(header.record_bytes),
      scale_(header.scale),
      offset_(header.offset),
      withheld_(withheld_bit(header)) {
  add_format_columns(header);
  take_normals(extra);
  name_apart(extra);
  for (StoredValue& value : extra) columns_.push_back({std::move(value)});
  list_attributes();
}

void Layout::list_attributes() {
  schema_.attributes.clear();
  for (const Column& column : columns_)
    schema_.attributes.push_back({column.value.name, cloud_type(column.value)});
}

void Layout::keep_attributes(const std::function<bool(const std::string& name)>& is_wanted) {
  std::erase_if(columns_, [&](const Column& column) { return !is_wanted(column.value.name); });
  list_attributes();
}

void Layout::add_field(const char* name, ScalarType type, std::size_t offset) {
  columns_.push_back({{.name = name, .type = type, .offset = offset}});
}

void Layout::add_bits(const char* name, std::size_t offset, unsigned shift, unsigned mask) {
  columns_.push_back({{.name = name, .type = ScalarType::kUint8, .offset = offset}, shift, mask});
}

void Layout::add_format_columns(const Header& header) {
  using S = ScalarType;
  add_field("intensity", S::kUint16, kIntensity);
  if (header.point_format < kFirstLongFormat)
    add_short_fields();
  else
    add_long_fields();
  const OptionalFields fields = kOptionalFields.at(header.point_format);
  if (fields.gps_time != 0) add_field("gps_time", S::kFloat64, fields.gps_time);
  if (fields.red != 0) {
    add_field("red", S::kUint16, fields.red);
    add_field("green", S::kUint16, fields.red + 2u);
    add_field("blue", S::kUint16, fields.red + 4u);
  }
  if (fields.nir != 0) add_field("nir", S::kUint16, fields.nir);
}

/// Formats 0 to 5.
void Layout::add_short_fields() {
  add_bits("return_number", kReturns, 0, 7);
  add_bits("number_of_returns", kReturns, 3, 7);
  add_bits("classification", kFlags, 0, 31);
  add_field("scan_angle_rank", ScalarType::kInt8, 16);
  add_field("user_data", ScalarType::kUint8, 17);
  add_field("point_source_id", ScalarType::kUint16, 18);
}

/// Formats 6 to 10.
void Layout::add_long_fields() {
  add_bits("return_number", kReturns, 0, 15);
  add_bits("number_of_returns", kReturns, 4, 15);
  add_field("classification", ScalarType::kUint8, 16);
  add_field("user_data", ScalarType::kUint8, 17);
  add_field("scan_angle", ScalarType::kInt16, 18);
  add_field("point_source_id", ScalarType::kUint16, 20);
}

/// Moves the components of the normal, where all three are there, from the extra values.
void Layout::take_normals(std::vector<StoredValue>& extra) {
  std::array<const StoredValue*, 3> found{};
  for (const StoredValue& value : extra) {
    const std::size_t axis = normal_axis(value.name);
    if (axis < 3 && found[axis] == nullptr) found[axis] = &value;
  }
  schema_.has_normals = std::find(found.begin(), found.end(), nullptr) == found.end();
  if (!schema_.has_normals) return;
  schema_.normal_type = ScalarType::kFloat32;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    normal_[axis] = *found[axis];
    if (cloud_type(normal_[axis]) != ScalarType::kFloat32)
      schema_.normal_type = ScalarType::kFloat64;
  }
  std::erase_if(extra, [&](const StoredValue& value) {
    return std::any_of(normal_.begin(), normal_.end(), [&](const StoredValue& component) {
      return component.offset == value.offset;
    });
  });
}

/// Gives each extra value a name that no other attribute and no coordinate has.
void Layout::name_apart(std::vector<StoredValue>& extra) const {
  DistinctNames names({"x", "y", "z", "nx", "ny", "nz"});
  for (const Column& column : columns_) names.take(column.value.name);
  for (StoredValue& value : extra) value.name = names.give(plain_name(value.name));
}

bool Layout::is_withheld(const std::byte* record) const {
  return (record[kFlags] & withheld_) != std::byte{0};
}

void Layout::append_positions(const std::byte* records, std::size_t count, Vec3* to) const {
  const Vec3 scale = scale_;
  const Vec3 offset = offset_;
  const std::size_t stride = record_bytes_;
  for (std::size_t i = 0; i < count; ++i, records += stride) {
    to[i].x = load_little<std::int32_t>(records) * scale.x + offset.x;
    to[i].y = load_little<std::int32_t>(records + 4) * scale.y + offset.y;
    to[i].z = load_little<std::int32_t>(records + 8) * scale.z + offset.z;
  }
}

void Layout::append_column(const Column& column, const std::byte* records, std::size_t count,
                           std::byte* to, std::size_t to_stride) const {
  const std::size_t stride = record_bytes_;
  const std::byte* from = records + column.value.offset;
  if (column.mask != 0) {
    for (std::size_t i = 0; i < count; ++i, from += stride, to += to_stride)
      *to = (*from >> column.shift) & static_cast<std::byte>(column.mask);
    return;
  }
  visit_scalar(column.value.type, [&](auto kind) {
    using T = decltype(kind);
    for (std::size_t i = 0; i < count; ++i, from += stride, to += to_stride) {
      if (column.value.is_scaled) {
        const double value = meaning<T>(column.value, from - column.value.offset);
        std::memcpy(to, &value, sizeof value);
      } else {
        const auto bits = load_little<Bits<sizeof(T)>>(from);
        std::memcpy(to, &bits, sizeof bits);
      }
    }
  });
}

void Layout::append_normals(const std::byte* records, std::size_t count, Vec3* to) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const StoredValue& value = normal_[axis];
    visit_scalar(value.type, [&](auto kind) {
      const std::byte* from = records;
      for (std::size_t i = 0; i < count; ++i, from += record_bytes_)
        to[i][static_cast<int>(axis)] = meaning<decltype(kind)>(value, from);
    });
  }
}

void Layout::append(const std::byte* records, std::size_t count, PointCloud& cloud) const {
  if (count == 0) return;
  const std::size_t first = cloud.positions.size();
  cloud.positions.resize(first + count);
  append_positions(records, count, cloud.positions.data() + first);
  if (schema_.has_normals) {
    cloud.normals.resize(first + count);
    append_normals(records, count, cloud.normals.data() + first);
  }
  const std::size_t row_bytes = schema_.attribute_bytes();
  cloud.attributes.resize((first + count) * row_bytes);
  std::byte* to = cloud.attributes.data() + first * row_bytes;
  for (const Column& column : columns_) {
    append_column(column, records, count, to, row_bytes);
    to += size_of(cloud_type(column.value));
  }
}

}  // namespace orbweave::las
