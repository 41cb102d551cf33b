// Where the chunks of a LAZ file lie and how many points each one holds.
//
// Source: format of LASzip (docs/dev/laz.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "io/clouds/laz/laszip_record.h"
#include "io/streams/random_access.h"

namespace orbweave::laz {

struct Chunk {
  std::uint64_t begin = 0, end = 0;  ///< bytes of the file
  std::uint64_t points = 0;          ///< at least 1
};

struct ChunkTable {
  /// Hold all points together.
  std::vector<Chunk> chunks;
  /// True when the writer was interrupted and left no table: chunks is empty, and each chunk begins
  /// where the one before ends. The first begins at `first_begin`.
  bool missing = false;
  std::uint64_t first_begin = 0;
};

/// Reads the table of a file whose `points` > 0 points begin at `point_data_offset`. A file without
/// chunks is one chunk. Memory is in proportion to the file, whatever the table claims.
/// Throws Error (bad input) for a table that is damaged, does not fit the file or does not hold
/// all points, and for a missing one that cannot be done without.
ChunkTable read_chunk_table(const RandomAccess& file, const LaszipRecord& record,
                            std::uint64_t point_data_offset, std::uint64_t points,
                            std::size_t record_bytes);

}  // namespace orbweave::laz
