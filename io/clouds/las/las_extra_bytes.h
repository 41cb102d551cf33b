// What LAS files say of the bytes that follow the fields of a point's format.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave::las {

/// A value that is stored in a point's record.
struct StoredValue {
  std::string name;
  ScalarType type = ScalarType::kUint8;  ///< as stored
  std::size_t offset = 0;                ///< bytes from the record's begin
  bool is_scaled = false;                ///< means stored * scale + shift, a double
  double scale = 1.0;
  double shift = 0.0;
};

/// The values that the payload of the extra bytes record ("LASF_Spec" 4) describes, in bytes
/// [first, record_bytes) of each point. An array of two or three (of LAS 1.4 before R14) becomes as
/// many values, "name_0" and so on; undocumented bytes are passed over; a description that reaches
/// beyond the record, or is of an unknown type, ends the list. Names are as the file gives them,
/// perhaps empty or twice the same. LAS Specification 1.4 R15, section 2.6, table 24.
std::vector<StoredValue> extra_values(std::span<const std::byte> payload, std::size_t first,
                                      std::size_t record_bytes);

}  // namespace orbweave::las
