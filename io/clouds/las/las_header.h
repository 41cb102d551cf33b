// The public header of LAS files.
#pragma once

#include <cstdint>
#include <string>

#include "io/box.h"
#include "io/streams/random_access.h"
#include "io/vec3.h"

namespace orbweave::las {

/// What a reader needs of the public header block. ASPRS, LAS Specification 1.4 R15, section 2.4
/// (and 1.0 to 1.3, which it contains).
struct Header {
  std::uint8_t version_minor = 0;             ///< of version 1.minor, 0 to 4
  std::uint8_t point_format = 0;              ///< 0 to 10
  bool is_compressed = false;                 ///< the point data is LAZ
  bool says_wkt = false;                      ///< the coordinate system is to be taken from WKT
  std::uint16_t header_bytes = 0;             ///< where the variable length records begin
  std::uint32_t variable_records = 0;         ///< their number, as claimed
  std::uint32_t point_data_offset = 0;        ///< within the file
  std::uint16_t record_bytes = 0;             ///< of a point; at least point_format_bytes()
  std::uint64_t points = 0;                   ///< what the file holds, unless it is compressed
  std::uint64_t extended_records_offset = 0;  ///< as claimed
  std::uint32_t extended_records = 0;         ///< their number, as claimed
  Vec3 scale;                                 ///< finite and not zero, unless there are no points
  Vec3 offset;                                ///< finite, unless there are no points
  std::string software;                       ///< that wrote the file, as claimed
  Box bounds;                                 ///< as claimed; may be anything
};

/// Bytes that the specification gives to a point of this format, 0 to 10.
std::uint16_t point_format_bytes(std::uint8_t format);

/// Reads and checks the header. The number of points is the 64-bit one from LAS 1.4 on, and the
/// legacy one where that is 0. Throws Error (bad input), naming field and byte, for what is no LAS
/// file, an unknown version or point format, and points for which the file is too short.
Header read_header(const RandomAccess& file);

}  // namespace orbweave::las
