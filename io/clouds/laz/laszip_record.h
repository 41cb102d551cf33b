// The record "laszip encoded", 22204, which says how a LAZ file's points are compressed.
//
// Source: format of LASzip (docs/dev/laz.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace orbweave::laz {

enum class ItemType : std::uint16_t {
  kByte = 0,
  kPoint10 = 6,
  kGpsTime11 = 7,
  kRgb12 = 8,
  kWavePacket13 = 9,
  kPoint14 = 10,
  kRgb14 = 11,
  kRgbNir14 = 12,
  kWavePacket14 = 13,
  kByte14 = 14
};

/// One part of a point record, as it is coded.
struct ItemLayout {
  ItemType type = ItemType::kByte;
  std::size_t bytes = 0;      ///< of the uncompressed part
  std::uint16_t version = 0;  ///< of its coding
};

/// How the points are arranged.
enum class Arrangement {
  kOneStream,  ///< compressor 1: all points in one coded stream
  kChunks,     ///< compressor 2: independent streams
  kLayers      ///< compressor 3: independent chunks of one stream per attribute
};

struct LaszipRecord {
  Arrangement arrangement = Arrangement::kOneStream;
  /// Points of every chunk but the last; 0 when each chunk has a number of its own, or there is
  /// one.
  std::uint32_t chunk_points = 0;
  std::vector<ItemLayout> items;
};

/// Reads the record's payload and checks it against the LAS header's `point_format` (without the
/// bits that mark compression) and `record_bytes`. `file` is named in messages.
/// Throws Error (bad input) for a payload that is cut short, contradicts the header or itself, and
/// for a compressor, coder, item or version that is not known.
LaszipRecord parse_laszip_record(std::span<const std::byte> payload, unsigned point_format,
                                 std::size_t record_bytes, const std::string& file);

}  // namespace orbweave::laz
