// Packed rows of typed values, as files hold them, into the parallel arrays of a PointCloud.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave {

/// A value's place in a row.
struct RowColumn {
  std::string name;
  ScalarType type = ScalarType::kFloat64;
  std::size_t offset = 0;  ///< bytes from the row's start
};

/// What a row's columns mean: x, y, z are the position; nx, ny, nz, when all three are there, the
/// normal; everything else is an attribute.
class PointRowLayout {
 public:
  PointRowLayout() = default;
  /// `swap_bytes`: the rows' byte order is not the machine's.
  PointRowLayout(const std::vector<RowColumn>& columns, std::size_t row_bytes, bool swap_bytes);

  /// Names among x, y, z that the columns lack, joined by ", "; empty when it is a cloud.
  const std::string& missing() const { return missing_; }
  const PointSchema& schema() const { return schema_; }
  std::size_t row_bytes() const { return row_bytes_; }
  /// Appends `count` points to a cloud that has this layout's schema.
  void append(const std::byte* rows, std::size_t count, PointCloud& cloud) const;

 private:
  template <bool kSwap>
  void append_rows(const std::byte* rows, std::size_t count, PointCloud& cloud) const;

  PointSchema schema_;
  std::array<RowColumn, 3> position_;
  std::array<RowColumn, 3> normal_;
  std::vector<RowColumn> attributes_;
  std::size_t row_bytes_ = 0;
  bool swap_bytes_ = false;
  std::string missing_;
};

}  // namespace orbweave
