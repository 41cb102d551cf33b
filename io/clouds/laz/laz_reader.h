// Point records of a LAZ file, as the uncompressed LAS file would hold them.
//
// Format: Martin Isenburg, LASzip: lossless compression of LiDAR data, Photogrammetric Engineering
// and Remote Sensing 79(2), 2013, and what LASzip writes (docs/dev/laz.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "io/streams/random_access.h"

namespace orbweave {

/// Decompresses the point data of one LAZ file in order. Several chunks are decoded at a time by
/// the threads of the calling TBB arena; what is read does not depend on their number.
/// Memory: a few chunks (compressed and decompressed), never more than the file's size justifies.
class LazReader {
 public:
  /// `laszip_vlr` is the payload of the record "laszip encoded", 22204; `point_data_offset`,
  /// `points`, `point_format` (without the bits that mark compression) and `record_bytes` are the
  /// LAS header's. `file` must outlive the reader.
  /// Throws Error (bad input) for a damaged record, one that does not fit the header, a damaged
  /// table of chunks, and a compressor, coder or item that is not known, with its name.
  LazReader(const RandomAccess& file, std::span<const std::byte> laszip_vlr,
            std::uint64_t point_data_offset, std::uint64_t points, std::uint8_t point_format,
            std::uint16_t record_bytes);
  ~LazReader();
  LazReader(LazReader&&) noexcept;
  LazReader& operator=(LazReader&&) noexcept;

  /// Fills `records` with the next whole records; returns how many, 0 only at the end or when
  /// `records` holds less than one. Throws Error (bad input) where the data is damaged or ends too
  /// soon, with the byte of the file; a further call throws again.
  std::size_t read(std::span<std::byte> records);
  /// Compressed bytes of the file behind the records handed out so far; for progress.
  std::uint64_t bytes_read() const;

 private:
  class Decoding;
  std::unique_ptr<Decoding> decoding_;
};

}  // namespace orbweave
