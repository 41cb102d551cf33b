// The header of a PCD file, the format of the Point Cloud Library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/points/point_rows.h"
#include "io/points/point_source.h"
#include "io/streams/byte_reader.h"

namespace orbweave {

enum class PcdData { kAscii, kBinary, kCompressed };

struct PcdField {
  std::string name;
  ScalarType type = ScalarType::kFloat32;
  std::size_t count = 1;  ///< values per point
  std::size_t bytes() const { return count * size_of(type); }
  bool is_padding() const { return name == "_"; }
  /// Colours in the four bytes of one number: 0xAARRGGBB.
  bool is_packed_color() const;
};

struct PcdHeader {
  std::string version;  ///< as written; empty where the header does not say
  std::vector<PcdField> fields;
  std::uint64_t points = 0;
  std::optional<Vec3> viewpoint;  ///< its translation, where it is not the default
  PcdData data = PcdData::kAscii;
  std::size_t row_bytes = 0;   ///< of a point, padding included
  std::size_t row_values = 0;  ///< numbers of a point, padding included
};

/// Reads the header up to and with its DATA line: versions 0.5 to 0.7. A file without SIZE, TYPE
/// and COUNT (0.5) has floats; one without POINTS has WIDTH * HEIGHT of them.
/// Format: Point Cloud Library, The PCD (Point Cloud Data) file format.
/// Throws Error (bad input) with file and line, also where a point has more than 4096 values.
PcdHeader read_pcd_header(ByteReader& reader);

/// The fields of a row, padding left out: packed colours taken apart, fields of several values as
/// name_0, name_1, ...; the names that roles go by (x, nx, red, intensity, ...) in lower case.
/// Throws Error (bad input) where two have one name.
std::vector<RowColumn> pcd_columns(const PcdHeader& header, const std::string& file);

}  // namespace orbweave
