// utm_scan FILE.laz TRUTH: a scan as a surveyor has it, for bench/quality/round_trip.py. A LAZ file
// of point format 3 in UTM zone 12 N with 16-bit colours, intensities, classes and GPS times,
// compressed by the encoder of the tests; TRUTH gets what it holds: per point three doubles, the
// time, and five 16-bit numbers (red, green, blue, intensity, class).
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <span>
#include <string>
#include <vector>

#include "tests/io/las_files.h"
#include "tests/io/laz_encoder.h"

namespace {

using namespace orbweave;
using namespace orbweave::test;

constexpr int kSide = 160;  // points along each side of the ground
constexpr double kScale = 0.0001;
constexpr std::array<double, 3> kOffset{448'000.0, 4'511'000.0, 1300.0};
constexpr std::uint16_t kEpsg = 26912;

/// Integers that look like noise, the same on every machine.
std::uint32_t noise(std::uint32_t i) {
  i = (i ^ 61u) ^ (i >> 16);
  i *= 9u;
  i ^= i >> 4;
  i *= 0x27d4eb2du;
  return i ^ (i >> 15);
}

/// Gentle hills, 5 cm between points.
LasPoint ground_point(int i) {
  const int column = i % kSide, row = i / kSide;
  LasPoint point;
  const auto u = static_cast<std::uint32_t>(i);
  point.xyz = {500 * column + static_cast<int>(noise(u) % 60),
               500 * row + static_cast<int>(noise(u + 7) % 60),
               static_cast<int>(4000.0 * std::sin(column * 0.05) * std::cos(row * 0.04)) +
                   static_cast<int>(noise(u + 13) % 20)};
  point.intensity = static_cast<std::uint16_t>(noise(u + 17));
  point.return_number = point.number_of_returns = 1;
  point.classification = 2 + noise(u + 19) % 5;
  point.point_source_id = 7;
  point.gps_time = 315'000'000.0 + i * 1.25e-5;
  for (std::uint32_t c = 0; c < 3; ++c)
    point.rgb_nir[c] = static_cast<std::uint16_t>(noise(u * 3 + c));
  return point;
}

template <class T>
void write(std::ofstream& file, T value) {
  file.write(reinterpret_cast<const char*>(&value), sizeof value);
}

void write_truth(std::ofstream& file, const LasPoint& point) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double scaled = point.xyz[axis] * kScale;
    write(file, scaled + kOffset[axis]);
  }
  write(file, point.gps_time);
  for (std::size_t c = 0; c < 3; ++c) write(file, point.rgb_nir[c]);
  write(file, point.intensity);
  write(file, static_cast<std::uint16_t>(point.classification));
}

std::string geo_keys() {
  std::string payload;
  constexpr std::array<std::uint16_t, 12> kKeys{1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, kEpsg};
  for (const std::uint16_t value : kKeys) payload += raw(value);
  return variable_record("LASF_Projection", 34735, payload);
}

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The header of a file without points, that says how many there are, compressed.
std::string compressed_file(const LazFile& laz) {
  LasFile front{.minor = 2, .format = 3};
  front.variable_records = {geo_keys(), variable_record("laszip encoded", 22204, text_of(laz.vlr))};
  front.scale = {kScale, kScale, kScale};
  front.offset = kOffset;
  front.stored_format = 3 | 128;
  front.legacy_points = static_cast<std::uint32_t>(laz.points);
  const std::string header = front.bytes();
  std::string points = text_of(laz.bytes).substr(laz.data_offset);
  std::uint64_t table = 0;  // counted from the front of the file
  points.copy(reinterpret_cast<char*>(&table), sizeof table);
  table += header.size() - laz.data_offset;
  points.replace(0, sizeof table, reinterpret_cast<const char*>(&table), sizeof table);
  return header + points;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: utm_scan FILE.laz TRUTH\n";
    return 2;
  }
  std::ofstream truth(argv[2], std::ios::binary);
  std::vector<std::uint8_t> records;
  for (int i = 0; i < kSide * kSide; ++i) {
    const LasPoint point = ground_point(i);
    const std::string record = las_record(3, point);
    records.insert(records.end(), record.begin(), record.end());
    write_truth(truth, point);
  }
  const LazFile laz = encode_laz({.point_format = 3, .chunk_points = 5000}, records);
  std::ofstream(argv[1], std::ios::binary) << compressed_file(laz);
  return truth.flush() ? 0 : 1;
}
