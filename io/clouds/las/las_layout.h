// Point records of LAS files into the parallel arrays of a PointCloud.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "io/clouds/las/las_extra_bytes.h"
#include "io/clouds/las/las_header.h"
#include "io/point_cloud.h"

namespace orbweave::las {

/// What a record of a point format, with its extra bytes, becomes. Position: integer * scale +
/// offset, in doubles, rounded after each step. Normals: extra values NormalX, NormalY, NormalZ
/// or nx, ny, nz (in any case), where all three are there. Attributes: the format's fields, then
/// the extra values, each at its own width, scaled ones as float64. Scan flags, the scanner
/// channel, waveform packets and bytes that nothing describes are left behind.
class Layout {
 public:
  Layout(const Header& header, std::vector<StoredValue> extra);

  /// Leaves the attributes whose names are wanted.
  void keep_attributes(const std::function<bool(const std::string& name)>& is_wanted);

  const PointSchema& schema() const { return schema_; }
  std::size_t record_bytes() const { return record_bytes_; }
  /// The writer marked the point as one not to be used.
  bool is_withheld(const std::byte* record) const;
  /// Appends `count` points to a cloud of this schema.
  void append(const std::byte* records, std::size_t count, PointCloud& cloud) const;

 private:
  /// Bits of a stored byte, or all of a stored value.
  struct Column {
    StoredValue value;
    unsigned shift = 0;
    unsigned mask = 0;  ///< 0: the whole value
  };

  void list_attributes();
  void add_format_columns(const Header& header);
  void add_short_fields();
  void add_long_fields();
  void add_field(const char* name, ScalarType type, std::size_t offset);
  void add_bits(const char* name, std::size_t offset, unsigned shift, unsigned mask);
  void take_normals(std::vector<StoredValue>& extra);
  void name_apart(std::vector<StoredValue>& extra) const;
  void append_positions(const std::byte* records, std::size_t count, Vec3* to) const;
  void append_normals(const std::byte* records, std::size_t count, Vec3* to) const;
  void append_column(const Column& column, const std::byte* records, std::size_t count,
                     std::byte* to, std::size_t to_stride) const;

  PointSchema schema_;
  std::size_t record_bytes_ = 0;
  Vec3 scale_;
  Vec3 offset_;
  std::vector<Column> columns_;
  std::array<StoredValue, 3> normal_;
  std::byte withheld_{0};
};

}  // namespace orbweave::las
