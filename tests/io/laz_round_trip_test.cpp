// The LAZ decoder against an encoder that shares none of its coding.
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "io/clouds/laz/laz_reader.h"
#include "io/clouds/laz/return_contexts.h"
#include "tests/io/laz_encoder.h"
#include "tests/io/laz_reading.h"
#include "tests/io/laz_records.h"

namespace orbweave::test {
namespace {

std::string named(const LazOptions& options) {
  return "point format " + std::to_string(options.point_format) + ", " +
         std::to_string(options.extra_bytes) + " extra bytes, version " +
         std::to_string(options.layer_version);
}

/// Every point format with and without extra bytes; layers in both versions.
std::vector<LazOptions> all_layouts() {
  std::vector<LazOptions> layouts;
  for (unsigned format = 0; format <= 10; ++format)
    for (const std::size_t extra : {0, 5})
      for (unsigned version = 3; version <= (format < 6 ? 3U : 4U); ++version)
        layouts.push_back({.point_format = format,
                           .extra_bytes = extra,
                           .compressor = format < 6 ? 2U : 3U,
                           .layer_version = version});
  return layouts;
}

void check_round_trip(const LazOptions& options, const std::vector<std::uint8_t>& records) {
  INFO(named(options));
  const LazFile file = encode_laz(options, records);
  CHECK(read_laz(file) == records);
}

TEST_CASE("EveryPointFormatIsReadAsItWasWritten", "[costly]") {
  for (const LazOptions& options : all_layouts()) {
    check_round_trip(options, random_records(options, 437, 1));
    check_round_trip(options, scan_records(options, 1734, 2));
  }
}

TEST_CASE("ChunksOfDifferentSizesAreReadAsTheyWereWritten") {
  for (const unsigned format : {3U, 7U}) {
    LazOptions options{.point_format = format, .compressor = format < 6 ? 2U : 3U};
    options.chunk_points = 0;
    check_round_trip(options, scan_records(options, 1000, 3));
    options.chunk_points = 1;
    check_round_trip(options, scan_records(options, 50, 4));
  }
}

TEST_CASE("TheTableOfChunksMayBeNamedAtTheEnd") {
  LazOptions options{.point_format = 1};
  options.table = TablePlace::kNamedAtEnd;
  check_round_trip(options, scan_records(options, 500, 5));
}

TEST_CASE("ChunksAreFoundWithoutATableWhenTheyHoldTheSameNumberOfPoints") {
  for (const unsigned format : {1U, 6U}) {
    LazOptions options{.point_format = format, .compressor = format < 6 ? 2U : 3U};
    options.table = TablePlace::kMissing;
    check_round_trip(options, scan_records(options, 730, 6));
    options.chunk_points = 1;
    check_round_trip(options, scan_records(options, 20, 7));
  }
}

TEST_CASE("PointsInOneStreamAreRead") {
  const LazOptions options{.point_format = 3, .compressor = 1};
  check_round_trip(options, scan_records(options, 3000, 8));
}

TEST_CASE("LongChunksKeepTheProbabilitiesOfTheFormat", "[costly]") {
  // Counts are halved from time to time; that takes tens of thousands of symbols.
  const LazOptions options{.point_format = 1, .compressor = 2, .chunk_points = 60000};
  check_round_trip(options, scan_records(options, 60000, 9));
}

TEST_CASE("AChunkTooLargeForMemoryIsReadPieceByPiece", "[costly]") {
  const LazOptions options{
      .point_format = 0, .extra_bytes = 1000, .compressor = 2, .chunk_points = 9000};
  const auto records = scan_records({.point_format = 0}, 9000, 10);
  std::vector<std::uint8_t> wide;
  for (std::size_t i = 0; i < 9000; ++i) {
    wide.insert(wide.end(), &records[20 * i], &records[20 * i] + 20);
    wide.insert(wide.end(), 1000, static_cast<std::uint8_t>(i / 1000));
  }
  check_round_trip(options, wide);
}

TEST_CASE("WhatIsReadDoesNotDependOnThreadsOrOnHowMuchIsAskedFor") {
  const LazOptions options{.point_format = 7, .compressor = 3};
  const auto records = scan_records(options, 2345, 11);
  const LazFile file = encode_laz(options, records);
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 5);
  for (const int threads : {1, 2, 5}) {
    tbb::task_arena arena(threads);
    for (const std::size_t points : {1U, 7U, 100U, 5000U})
      arena.execute([&] { CHECK(read_laz(file, points) == records); });
  }
}

TEST_CASE("NoRoomForARecordReadsNothingAndLosesNothing") {
  const LazOptions options{.point_format = 0};
  const auto records = scan_records(options, 150, 12);
  const LazFile file = encode_laz(options, records);
  OpenLaz laz(file);
  std::vector<std::byte> small(19);
  CHECK(laz.reader.read(small) == 0);
  std::vector<std::byte> odd(20 * 200 + 13);
  CHECK(laz.reader.read(odd) == 150);
  CHECK(laz.reader.read(odd) == 0);
}

TEST_CASE("BytesReadGrowToTheEndOfThePoints") {
  const LazOptions options{.point_format = 1};
  const LazFile file = encode_laz(options, scan_records(options, 1000, 13));
  OpenLaz laz(file);
  std::vector<std::byte> some(28 * 30);
  std::uint64_t before = laz.reader.bytes_read();
  while (laz.reader.read(some) > 0) {
    CHECK(laz.reader.bytes_read() >= before);
    before = laz.reader.bytes_read();
  }
  const std::uint64_t all = file.bytes.size() - file.data_offset;
  CHECK(before < all);  // the table is behind them
  CHECK(before > all * 9 / 10);
}

TEST_CASE("AFileWithoutPointsNeedsNoTable") {
  LazFile file = encode_laz({.point_format = 1}, {});
  file.bytes.resize(file.data_offset);
  CHECK(read_laz(file).empty());
}

TEST_CASE("PointsBehindThoseOfTheHeaderAreLeftOut") {
  const LazOptions options{.point_format = 6, .compressor = 3};
  auto records = scan_records(options, 300, 14);
  LazFile file = encode_laz(options, records);
  file.points = 150;
  records.resize(150 * record_bytes(options));
  CHECK(read_laz(file) == records);
}

TEST_CASE("TheStreamingMedianDropsLargestAndSmallestInTurn") {
  laz::StreamingMedian median;
  // From 0 0 0 0 0: 7 drops a largest 0, then 5, 9 and 1 a smallest one, as all but 1 lie above the
  // median; -4 and -4 drop the largest, 3 too, and then 3 and 8 the smallest.
  std::vector<std::int32_t> medians;
  for (const std::int32_t value : {7, 5, 9, 1, -4, -4, 3, 3, 8}) {
    median.add(value);
    medians.push_back(median.get());
  }
  CHECK(medians == std::vector<std::int32_t>{0, 0, 5, 5, 1, 0, 0, 1, 3});
}

}  // namespace
}  // namespace orbweave::test
