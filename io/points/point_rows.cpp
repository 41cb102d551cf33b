#include "io/points/point_rows.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <iterator>

#include "io/scalar_types.h"

namespace orbweave {
namespace {

constexpr std::array<double Vec3::*, 3> kAxes = {&Vec3::x, &Vec3::y, &Vec3::z};

template <std::size_t kBytes, bool kSwap>
inline void copy_value(const std::byte* from, std::byte* to) {
  if constexpr (!kSwap || kBytes == 1) {
    std::memcpy(to, from, kBytes);
  } else {
    for (std::size_t b = 0; b < kBytes; ++b) to[b] = from[kBytes - 1 - b];
  }
}

template <class T, bool kSwap>
void gather_as(const std::byte* from, std::size_t row_bytes, std::size_t count, double Vec3::*axis,
               Vec3* to) {
  for (std::size_t i = 0; i < count; ++i, from += row_bytes) {
    T value;
    copy_value<sizeof(T), kSwap>(from, reinterpret_cast<std::byte*>(&value));
    to[i].*axis = static_cast<double>(value);
  }
}

/// One coordinate of `count` rows.
template <bool kSwap>
void gather(const std::byte* rows, std::size_t row_bytes, const RowColumn& column,
            std::size_t count, double Vec3::*axis, Vec3* to) {
  const std::byte* from = rows + column.offset;
  visit_scalar(column.type, [&](auto kind) {
    gather_as<decltype(kind), kSwap>(from, row_bytes, count, axis, to);
  });
}

template <std::size_t kBytes, bool kSwap>
void copy_column(const std::byte* from, std::size_t from_row, std::size_t count, std::byte* to,
                 std::size_t to_row) {
  for (std::size_t i = 0; i < count; ++i, from += from_row, to += to_row)
    copy_value<kBytes, kSwap>(from, to);
}

template <bool kSwap>
void copy_attribute(const std::byte* from, std::size_t from_row, ScalarType type, std::size_t count,
                    std::byte* to, std::size_t to_row) {
  switch (size_of(type)) {
    case 1:
      return copy_column<1, kSwap>(from, from_row, count, to, to_row);
    case 2:
      return copy_column<2, kSwap>(from, from_row, count, to, to_row);
    case 4:
      return copy_column<4, kSwap>(from, from_row, count, to, to_row);
    default:
      return copy_column<8, kSwap>(from, from_row, count, to, to_row);
  }
}

/// The floating type that holds all three exactly (64-bit integers apart).
ScalarType floating_type(const std::array<RowColumn, 3>& columns) {
  const bool narrow = std::all_of(columns.begin(), columns.end(), [](const RowColumn& column) {
    return column.type == ScalarType::kFloat32 || size_of(column.type) <= 2;
  });
  return narrow ? ScalarType::kFloat32 : ScalarType::kFloat64;
}

/// Finds the three columns; returns the names that are missing.
std::string find_three(const std::vector<RowColumn>& columns,
                       const std::array<const char*, 3>& names, std::array<RowColumn, 3>& found) {
  std::string missing;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = std::find_if(columns.begin(), columns.end(), [&](const RowColumn& column) {
      return column.name == names[axis];
    });
    if (at != columns.end())
      found[axis] = *at;
    else
      missing += (missing.empty() ? "" : ", ") + std::string(names[axis]);
  }
  return missing;
}

bool is_one_of(const std::string& name, const std::array<const char*, 3>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

PointRowLayout::PointRowLayout(const std::vector<RowColumn>& columns, std::size_t row_bytes,
                               bool swap_bytes)
    : row_bytes_(row_bytes), swap_bytes_(swap_bytes) {
  constexpr std::array<const char*, 3> kPosition = {"x", "y", "z"};
  constexpr std::array<const char*, 3> kNormal = {"nx", "ny", "nz"};
  missing_ = find_three(columns, kPosition, position_);
  schema_.has_normals = find_three(columns, kNormal, normal_).empty();
  schema_.position_type = floating_type(position_);
  if (schema_.has_normals) schema_.normal_type = floating_type(normal_);
  for (const RowColumn& column : columns) {
    if (is_one_of(column.name, kPosition)) continue;
    if (schema_.has_normals && is_one_of(column.name, kNormal)) continue;
    attributes_.push_back(column);
    schema_.attributes.push_back({column.name, column.type});
  }
}

template <bool kSwap>
void PointRowLayout::append_rows(const std::byte* rows, std::size_t count,
                                 PointCloud& cloud) const {
  const std::size_t first = cloud.positions.size();
  cloud.positions.resize(first + count);
  for (std::size_t axis = 0; axis < 3; ++axis)
    gather<kSwap>(rows, row_bytes_, position_[axis], count, kAxes[axis],
                  cloud.positions.data() + first);
  if (schema_.has_normals) {
    cloud.normals.resize(first + count);
    for (std::size_t axis = 0; axis < 3; ++axis)
      gather<kSwap>(rows, row_bytes_, normal_[axis], count, kAxes[axis],
                    cloud.normals.data() + first);
  }
  const std::size_t attribute_bytes = schema_.attribute_bytes();
  cloud.attributes.resize((first + count) * attribute_bytes);
  std::byte* to = cloud.attributes.data() + first * attribute_bytes;
  for (const RowColumn& column : attributes_) {
    copy_attribute<kSwap>(rows + column.offset, row_bytes_, column.type, count, to,
                          attribute_bytes);
    to += size_of(column.type);
  }
}

void PointRowLayout::append(const std::byte* rows, std::size_t count, PointCloud& cloud) const {
  if (count == 0) return;
  if (swap_bytes_)
    append_rows<true>(rows, count, cloud);
  else
    append_rows<false>(rows, count, cloud);
}

}  // namespace orbweave
