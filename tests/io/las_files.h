// LAS files made of values, for the tests of their reader; written by the tables of the LAS
// Specification 1.4 R15, apart from the code that reads them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/clouds/las/las_source.h"
#include "tests/io/reading.h"

namespace orbweave::test {

/// Every field that any point format has.
struct LasPoint {
  std::array<std::int32_t, 3> xyz{};
  std::uint16_t intensity = 0;
  unsigned return_number = 0;
  unsigned number_of_returns = 0;
  bool scan_direction = false;
  bool edge_of_flight_line = false;
  unsigned classification = 0;
  bool synthetic = false;
  bool key_point = false;
  bool withheld = false;
  bool overlap = false;
  unsigned scanner_channel = 0;
  std::int16_t scan_angle = 0;  ///< its low byte is the rank
  std::uint8_t user_data = 0;
  std::uint16_t point_source_id = 0;
  double gps_time = 0.0;
  std::array<std::uint16_t, 4> rgb_nir{};
  std::string wave_packet = std::string(29, 'w');
  std::string extra;
};

inline std::string byte(unsigned value) { return std::string(1, static_cast<char>(value)); }

inline bool has_gps_time(int format) { return format != 0 && format != 2; }
inline bool has_colours(int format) {
  return format == 2 || format == 3 || format == 5 || format == 7 || format == 8 || format == 10;
}
inline bool has_infrared(int format) { return format == 8 || format == 10; }
inline bool has_waves(int format) {
  return format == 4 || format == 5 || format == 9 || format == 10;
}

inline std::string las_record(int format, const LasPoint& p) {
  std::string record = raw(p.xyz[0]) + raw(p.xyz[1]) + raw(p.xyz[2]) + raw(p.intensity);
  const unsigned direction = p.scan_direction ? 1 : 0, edge = p.edge_of_flight_line ? 1 : 0;
  const unsigned marks = (p.synthetic ? 1u : 0u) | (p.key_point ? 2u : 0u) | (p.withheld ? 4u : 0u);
  if (format < 6) {
    record += byte(p.return_number | p.number_of_returns << 3 | direction << 6 | edge << 7);
    record += byte(p.classification | marks << 5);
    record += raw(static_cast<std::int8_t>(p.scan_angle & 0xff)) + byte(p.user_data);
  } else {
    record += byte(p.return_number | p.number_of_returns << 4);
    record +=
        byte(marks | (p.overlap ? 8u : 0u) | p.scanner_channel << 4 | direction << 6 | edge << 7);
    record += byte(p.classification) + byte(p.user_data) + raw(p.scan_angle);
  }
  record += raw(p.point_source_id);
  if (has_gps_time(format)) record += raw(p.gps_time);
  if (has_colours(format))
    for (std::size_t c = 0; c < 3; ++c) record += raw(p.rgb_nir[c]);
  if (has_infrared(format)) record += raw(p.rgb_nir[3]);
  if (has_waves(format)) record += p.wave_packet;
  return record + p.extra;
}

/// A variable length record; an extended one has a longer length field.
inline std::string variable_record(const std::string& user_id, unsigned record_id,
                                   const std::string& payload, bool is_extended = false) {
  std::string id = user_id;
  id.resize(16);
  const std::string length = is_extended ? raw(std::uint64_t{payload.size()})
                                         : raw(static_cast<std::uint16_t>(payload.size()));
  return std::string(2, '\0') + id + raw(static_cast<std::uint16_t>(record_id)) + length +
         std::string(32, 'd') + payload;
}

/// A whole file. What is not set is filled in as a careful writer would.
struct LasFile {
  int minor = 2;
  int format = 0;
  std::vector<std::string> variable_records{};
  std::vector<std::string> extended_records{};
  std::vector<std::string> records{};
  std::string gap{};  ///< between the variable length records and the points
  std::string tail{};
  std::uint16_t global_encoding = 0;
  std::array<double, 3> scale = {0.01, 0.01, 0.01};
  std::array<double, 3> offset = {0.0, 0.0, 0.0};
  std::optional<std::uint16_t> header_bytes{};
  std::optional<std::uint32_t> variable_record_count{};
  std::optional<std::uint32_t> point_data_offset{};
  std::optional<std::uint8_t> stored_format{};
  std::optional<std::uint16_t> record_bytes{};
  std::optional<std::uint32_t> legacy_points{};
  std::optional<std::uint64_t> points{};
  std::optional<std::uint64_t> extended_offset{};

  void add(const LasPoint& point) { records.push_back(las_record(format, point)); }
  std::string bytes() const;

 private:
  std::string public_header(std::size_t header, std::size_t first_point) const;
};

inline std::string joined(const std::vector<std::string>& parts) {
  std::string all;
  for (const std::string& part : parts) all += part;
  return all;
}

inline std::string LasFile::public_header(std::size_t header, std::size_t first_point) const {
  const auto u16 = [](auto v) { return raw(static_cast<std::uint16_t>(v)); };
  const auto u32 = [](auto v) { return raw(static_cast<std::uint32_t>(v)); };
  const std::size_t least = las_record(format, {}).size();
  const bool may_count_legacy = format < 6;
  std::string h = "LASF" + std::string(2, '\0') + raw(global_encoding) + std::string(16, 'g') +
                  byte(1) + byte(static_cast<unsigned>(minor)) + std::string(64, 's') + u16(1) +
                  u16(2026) + u16(header_bytes.value_or(static_cast<std::uint16_t>(header)));
  h += u32(point_data_offset.value_or(static_cast<std::uint32_t>(first_point)));
  h += u32(variable_record_count.value_or(static_cast<std::uint32_t>(variable_records.size())));
  h += byte(stored_format.value_or(static_cast<std::uint8_t>(format)));
  h += u16(record_bytes.value_or(
      static_cast<std::uint16_t>(records.empty() ? least : records.front().size())));
  h += u32(
      legacy_points.value_or(static_cast<std::uint32_t>(may_count_legacy ? records.size() : 0)));
  h += std::string(20, '\0');
  for (const double v : scale) h += raw(v);
  for (const double v : offset) h += raw(v);
  h += std::string(48, '\0');
  if (minor >= 3) h += raw(std::uint64_t{0});
  if (minor < 4) return h;
  const std::uint64_t behind = first_point + joined(records).size() + tail.size();
  h += raw(extended_offset.value_or(extended_records.empty() ? 0 : behind));
  h += u32(extended_records.size());
  return h + raw(points.value_or(records.size())) + std::string(120, '\0');
}

inline std::string LasFile::bytes() const {
  const std::size_t header = minor >= 4 ? 375 : minor == 3 ? 235 : 227;
  const std::string front = joined(variable_records) + gap;
  return public_header(header, header + front.size()) + front + joined(records) + tail +
         joined(extended_records);
}

/// A source over bytes, which must outlive it.
inline std::unique_ptr<PointSource> las_source(const std::string& bytes) {
  return open_las_source(memory_random_access(std::as_bytes(std::span(bytes)), "test.las"));
}

inline PointCloud read_las(const std::string& bytes) { return read_all(*las_source(bytes)); }

/// What reading these bytes throws; kind kNone where it throws nothing.
inline Error las_error(const std::string& bytes) {
  try {
    read_las(bytes);
  } catch (const Error& error) {
    return error;
  }
  return Error(ErrorKind::kNone, "");
}

}  // namespace orbweave::test
