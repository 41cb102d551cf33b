// The records of LAS files that say what is not said by the points themselves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "io/clouds/las/las_header.h"
#include "io/streams/random_access.h"

namespace orbweave::las {

/// A part of the file; it lies within it.
struct FileRange {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
};

/// Payloads of the variable length records, and the extended ones behind the points, that a
/// reader has a use for: the first of each kind.
struct VariableRecords {
  std::optional<FileRange> wkt;          ///< "LASF_Projection" 2112
  std::optional<FileRange> geo_keys;     ///< "LASF_Projection" 34735
  std::optional<FileRange> geo_ascii;    ///< "LASF_Projection" 34737
  std::optional<FileRange> extra_bytes;  ///< "LASF_Spec" 4
  std::optional<FileRange> laszip;       ///< "laszip encoded" 22204
};

/// Walks both lists. A count that promises more records than fit before the points (or the file's
/// end), and a record that would reach beyond, end the list: points can be read without it.
/// LAS Specification 1.4 R15, sections 2.5 and 2.7.
VariableRecords find_variable_records(const RandomAccess& file, const Header& header);

/// The bytes of a payload; none for one that is absent or so long (16 MiB) that it cannot be what
/// it says.
std::vector<std::byte> read_payload(const RandomAccess& file,
                                    const std::optional<FileRange>& range);

}  // namespace orbweave::las
