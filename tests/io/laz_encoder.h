// LAZ files of tests: an encoder of all point formats, as the format has it. Slow, and
// for records of any bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace orbweave::test {

enum class TablePlace { kNamedInFront, kNamedAtEnd, kMissing };

struct LazOptions {
  unsigned point_format = 0;
  std::size_t extra_bytes = 0;
  unsigned compressor = 2;         ///< 1 to 3
  unsigned layer_version = 3;      ///< of the items of compressor 3
  std::size_t chunk_points = 100;  ///< 0: chunks of 40, 1, 70, 40, 1, ... points
  TablePlace table = TablePlace::kNamedInFront;
};

std::size_t record_bytes(const LazOptions& options);

/// A file of `data_offset` bytes of anything, then points and table of chunks; and the payload of
/// its record "laszip encoded".
struct LazFile {
  std::vector<std::byte> bytes;
  std::vector<std::byte> vlr;
  std::uint64_t data_offset = 0;
  std::uint64_t points = 0;
  LazOptions options;
};

LazFile encode_laz(const LazOptions& options, std::span<const std::uint8_t> records);

/// Encodes the records of one chunk; `records` holds at least one.
std::vector<std::uint8_t> encode_pointwise_chunk(const LazOptions& options,
                                                 std::span<const std::uint8_t> records);
std::vector<std::uint8_t> encode_layered_chunk(const LazOptions& options,
                                               std::span<const std::uint8_t> records);

/// Appends little-endian.
template <class T>
void append(std::vector<std::uint8_t>& bytes, T value) {
  for (std::size_t b = 0; b < sizeof value; ++b)
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> 8 * b));
}

/// The little-endian unsigned integer at `at`.
template <class T>
T take(const std::uint8_t* at) {
  std::uint64_t value = 0;
  for (std::size_t b = 0; b < sizeof(T); ++b) value |= std::uint64_t{at[b]} << 8 * b;
  return static_cast<T>(value);
}

}  // namespace orbweave::test
