#include "io/clouds/laz/laszip_record.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "io/error.h"
#include "io/text/little_endian.h"

namespace orbweave::laz {
namespace {

constexpr std::size_t kFixedBytes = 34;  // up to and with the number of items
constexpr std::size_t kItemBytes = 6;
constexpr std::uint32_t kChunksOfAnySize = 0xffffffffU;

/// What is known of an item; kAnyBytes for those that hold as many as there are.
struct ItemKind {
  ItemType type;
  std::string_view name;
  std::size_t bytes;
  std::uint16_t oldest_version, newest_version;
};
constexpr std::size_t kAnyBytes = 0;
constexpr std::array<ItemKind, 10> kItemKinds{{
    {ItemType::kByte, "BYTE", kAnyBytes, 2, 2},
    {ItemType::kPoint10, "POINT10", 20, 2, 2},
    {ItemType::kGpsTime11, "GPSTIME11", 8, 2, 2},
    {ItemType::kRgb12, "RGB12", 6, 2, 2},
    {ItemType::kWavePacket13, "WAVEPACKET13", 29, 1, 1},
    {ItemType::kPoint14, "POINT14", 30, 3, 4},
    {ItemType::kRgb14, "RGB14", 6, 3, 4},
    {ItemType::kRgbNir14, "RGBNIR14", 8, 3, 4},
    {ItemType::kWavePacket14, "WAVEPACKET14", 29, 3, 4},
    {ItemType::kByte14, "BYTE14", kAnyBytes, 3, 4},
}};

/// The items of each point format, before any extra bytes.
using enum ItemType;
const std::array<std::vector<ItemType>, 11> kItemsOfFormat{{
    {kPoint10},
    {kPoint10, kGpsTime11},
    {kPoint10, kRgb12},
    {kPoint10, kGpsTime11, kRgb12},
    {kPoint10, kGpsTime11, kWavePacket13},
    {kPoint10, kGpsTime11, kRgb12, kWavePacket13},
    {kPoint14},
    {kPoint14, kRgb14},
    {kPoint14, kRgbNir14},
    {kPoint14, kWavePacket14},
    {kPoint14, kRgbNir14, kWavePacket14},
}};

[[noreturn]] void refuse(const std::string& file, const std::string& problem, std::string found,
                         std::string expected, std::string advice) {
  throw_bad_input(problem, {.file = file,
                            .place = "record \"laszip encoded\"",
                            .found = std::move(found),
                            .expected = std::move(expected),
                            .advice = std::move(advice)});
}

[[noreturn]] void refuse_damaged(const std::string& file, std::string found, std::string expected) {
  refuse(file, "the description of the compression is damaged", std::move(found),
         std::move(expected), "Copy or download the file again.");
}

[[noreturn]] void refuse_unknown(const std::string& file, std::string found, std::string expected) {
  refuse(file, "the points are compressed in a way that is not supported", std::move(found),
         std::move(expected), "Write the file again with a present LASzip, or as LAS.");
}

Arrangement arrangement_of(unsigned compressor, const std::string& file) {
  if (compressor < 1 || compressor > 3)
    refuse_unknown(file, "compressor " + std::to_string(compressor),
                   "1 (pointwise), 2 (pointwise, in chunks) or 3 (in layers)");
  return compressor == 1   ? Arrangement::kOneStream
         : compressor == 2 ? Arrangement::kChunks
                           : Arrangement::kLayers;
}

ItemLayout parse_item(const std::byte* at, const std::string& file) {
  const auto type = load_little<std::uint16_t>(at);
  const auto bytes = load_little<std::uint16_t>(at + 2);
  const auto version = load_little<std::uint16_t>(at + 4);
  const auto kind = std::find_if(kItemKinds.begin(), kItemKinds.end(), [&](const ItemKind& known) {
    return static_cast<unsigned>(known.type) == type;
  });
  if (kind == kItemKinds.end())
    refuse_unknown(file, "an item of type " + std::to_string(type), "0 or 6 to 14");
  const std::string name(kind->name);
  if (version < kind->oldest_version || version > kind->newest_version)
    refuse_unknown(file, "item " + name + " of version " + std::to_string(version),
                   std::to_string(kind->oldest_version) +
                       (kind->oldest_version == kind->newest_version
                            ? std::string()
                            : " or " + std::to_string(kind->newest_version)));
  if (kind->bytes == kAnyBytes ? bytes == 0 : bytes != kind->bytes)
    refuse_damaged(file, "item " + name + " of " + std::to_string(bytes) + " bytes",
                   kind->bytes == kAnyBytes ? "at least 1" : std::to_string(kind->bytes));
  return {static_cast<ItemType>(type), bytes, version};
}

/// The items must be those of the point format, in order, with what is left as extra bytes.
void check_items(const LaszipRecord& record, unsigned point_format, std::size_t record_bytes,
                 const std::string& file) {
  if (point_format >= kItemsOfFormat.size())
    refuse_unknown(file, "point format " + std::to_string(point_format), "0 to 10");
  const bool layered_format = point_format >= 6;
  if (layered_format != (record.arrangement == Arrangement::kLayers))
    refuse_damaged(file, "a compressor that does not go with the point format",
                   layered_format ? "compressor 3" : "compressor 1 or 2");
  std::vector<ItemType> expected = kItemsOfFormat[point_format];
  if (record.items.size() == expected.size() + 1)
    expected.push_back(layered_format ? kByte14 : kByte);
  const bool same =
      std::equal(record.items.begin(), record.items.end(), expected.begin(), expected.end(),
                 [](const ItemLayout& item, ItemType type) { return item.type == type; });
  if (!same)
    refuse_damaged(file, "items that are not those of point format " + std::to_string(point_format),
                   "them, and extra bytes if any");
  std::size_t bytes = 0;
  for (const ItemLayout& item : record.items) bytes += item.bytes;
  if (bytes != record_bytes)
    refuse_damaged(file, "items of " + std::to_string(bytes) + " bytes",
                   std::to_string(record_bytes) + ", the length of a point record");
}

}  // namespace

LaszipRecord parse_laszip_record(std::span<const std::byte> payload, unsigned point_format,
                                 std::size_t record_bytes, const std::string& file) {
  if (payload.size() < kFixedBytes)
    refuse_damaged(file, std::to_string(payload.size()) + " bytes",
                   "at least " + std::to_string(kFixedBytes));
  const std::byte* at = payload.data();
  LaszipRecord record;
  record.arrangement = arrangement_of(load_little<std::uint16_t>(at), file);
  if (const auto coder = load_little<std::uint16_t>(at + 2); coder != 0)
    refuse_unknown(file, "coder " + std::to_string(coder), "0 (arithmetic)");
  const auto chunk_points = load_little<std::uint32_t>(at + 12);
  if (record.arrangement != Arrangement::kOneStream && chunk_points != kChunksOfAnySize)
    record.chunk_points = chunk_points;
  const std::size_t items = load_little<std::uint16_t>(at + 32);
  if ((payload.size() - kFixedBytes) / kItemBytes < items)
    refuse_damaged(file, std::to_string(payload.size()) + " bytes",
                   std::to_string(items) + " items of " + std::to_string(kItemBytes) +
                       " bytes behind " + std::to_string(kFixedBytes));
  for (std::size_t i = 0; i < items; ++i)
    record.items.push_back(parse_item(at + kFixedBytes + i * kItemBytes, file));
  check_items(record, point_format, record_bytes, file);
  return record;
}

}  // namespace orbweave::laz
