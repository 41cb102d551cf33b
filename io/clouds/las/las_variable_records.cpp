#include "io/clouds/las/las_variable_records.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "io/text/little_endian.h"

namespace orbweave::las {
namespace {

constexpr std::uint64_t kLongestPayload = std::uint64_t{16} << 20;
constexpr std::size_t kUserId = 2;
constexpr std::size_t kUserIdBytes = 16;
constexpr std::size_t kRecordId = 18;
constexpr std::size_t kPayloadLength = 20;
constexpr std::size_t kRecordBytes = 54;
constexpr std::size_t kExtendedRecordBytes = 60;

/// Where a record of this owner and number is kept; null for one without use here.
std::optional<FileRange>* slot_of(VariableRecords& records, std::string_view user_id,
                                  std::uint16_t record_id) {
  struct Kind {
    std::string_view user_id;
    std::uint16_t record_id;
    std::optional<FileRange> VariableRecords::*slot;
  };
  constexpr std::array<Kind, 5> kKinds = {{
      {"LASF_Projection", 2112, &VariableRecords::wkt},
      {"LASF_Projection", 34735, &VariableRecords::geo_keys},
      {"LASF_Projection", 34737, &VariableRecords::geo_ascii},
      {"LASF_Spec", 4, &VariableRecords::extra_bytes},
      {"laszip encoded", 22204, &VariableRecords::laszip},
  }};
  for (const Kind& kind : kKinds)
    if (kind.user_id == user_id && kind.record_id == record_id) return &(records.*kind.slot);
  return nullptr;
}

void keep(VariableRecords& records, const std::byte* header, FileRange payload) {
  const std::string_view padded(reinterpret_cast<const char*>(header + kUserId), kUserIdBytes);
  auto* slot = slot_of(records, padded.substr(0, padded.find('\0')),
                       load_little<std::uint16_t>(header + kRecordId));
  if (slot != nullptr && !slot->has_value()) *slot = payload;
}

/// `Length` is the type of the field that holds a payload's length, 16 or 64 bits.
template <class Length>
void walk(const RandomAccess& file, std::uint64_t begin, std::uint64_t end, std::uint64_t count,
          VariableRecords& records) {
  constexpr std::size_t kHeaderBytes =
      sizeof(Length) == sizeof(std::uint16_t) ? kRecordBytes : kExtendedRecordBytes;
  std::array<std::byte, kHeaderBytes> header;
  for (; count != 0 && begin <= end && end - begin >= kHeaderBytes; --count) {
    file.read(begin, header);
    begin += kHeaderBytes;
    const std::uint64_t bytes = load_little<Length>(header.data() + kPayloadLength);
    if (bytes > end - begin) return;
    keep(records, header.data(), {begin, bytes});
    begin += bytes;
  }
}

/// The least place of the extended records that leaves the points alone.
std::uint64_t end_of_points(const Header& header) {
  return header.point_data_offset +
         (header.is_compressed ? 0 : header.points * header.record_bytes);
}

}  // namespace

VariableRecords find_variable_records(const RandomAccess& file, const Header& header) {
  VariableRecords records;
  walk<std::uint16_t>(file, header.header_bytes, header.point_data_offset, header.variable_records,
                      records);
  if (header.extended_records_offset >= end_of_points(header))
    walk<std::uint64_t>(file, header.extended_records_offset, file.size(), header.extended_records,
                        records);
  return records;
}

std::vector<std::byte> read_payload(const RandomAccess& file,
                                    const std::optional<FileRange>& range) {
  std::vector<std::byte> bytes;
  if (!range || range->bytes > kLongestPayload) return bytes;
  bytes.resize(static_cast<std::size_t>(range->bytes));
  file.read(range->offset, bytes);
  return bytes;
}

}  // namespace orbweave::las
