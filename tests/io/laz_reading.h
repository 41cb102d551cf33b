// Reading the LAZ files of laz_encoder.h.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "io/clouds/laz/laz_reader.h"
#include "tests/io/laz_encoder.h"

namespace orbweave::test {

/// A reader and the file it reads.
struct OpenLaz {
  explicit OpenLaz(const LazFile& laz)
      : file(memory_random_access(laz.bytes, "points.laz")),
        reader(*file, laz.vlr, laz.data_offset, laz.points,
               static_cast<std::uint8_t>(laz.options.point_format),
               static_cast<std::uint16_t>(record_bytes(laz.options))) {}

  std::unique_ptr<RandomAccess> file;
  LazReader reader;
};

/// All records, `points` at a time. Appends to `records` as they come, whatever happens then.
inline void read_laz(const LazFile& laz, std::vector<std::uint8_t>& records,
                     std::size_t points = 333) {
  OpenLaz open(laz);
  std::vector<std::uint8_t> some(points * record_bytes(laz.options));
  while (const std::size_t read = open.reader.read(std::as_writable_bytes(std::span(some))))
    records.insert(records.end(), some.begin(),
                   some.begin() + static_cast<long>(read * record_bytes(laz.options)));
}

inline std::vector<std::uint8_t> read_laz(const LazFile& laz, std::size_t points = 333) {
  std::vector<std::uint8_t> records;
  read_laz(laz, records, points);
  return records;
}

}  // namespace orbweave::test
