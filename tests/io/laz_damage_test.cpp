// Damaged and unknown LAZ files: told of with their place, never read outside of, and never
// trusted with memory.
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "io/clouds/laz/laz_reader.h"
#include "io/error.h"
#include "io/report/report.h"
#include "io/text/little_endian.h"
#include "tests/io/laz_encoder.h"
#include "tests/io/laz_reading.h"
#include "tests/io/laz_records.h"

namespace orbweave::test {
namespace {

using Catch::Contains;

/// What reading ends with, if not well; `records` are those before.
std::optional<Error> error_of(const LazFile& file, std::vector<std::uint8_t>& records,
                              int threads = 1) {
  try {
    tbb::task_arena arena(threads);
    arena.execute([&] { read_laz(file, records); });
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kBadInput);
    CHECK(error.parts().file == "points.laz");
    CHECK_FALSE(error.parts().place.empty());
    return error;
  }
  return std::nullopt;
}

std::string message_of(const LazFile& file) {
  std::vector<std::uint8_t> records;
  const auto error = error_of(file, records);
  return error ? error->what() : "";
}

bool begins_with(const std::vector<std::uint8_t>& whole, const std::vector<std::uint8_t>& part) {
  return part.size() <= whole.size() && std::equal(part.begin(), part.end(), whole.begin());
}

std::vector<LazOptions> some_layouts() {
  return {{.point_format = 3, .extra_bytes = 2, .compressor = 2},
          {.point_format = 5, .compressor = 1},
          {.point_format = 1, .compressor = 2, .table = TablePlace::kMissing},
          {.point_format = 10, .extra_bytes = 2, .compressor = 3, .chunk_points = 0},
          {.point_format = 7, .compressor = 3, .table = TablePlace::kMissing}};
}

TEST_CASE("AFileCutAnywhereIsRefusedAndNothingWrongIsHandedOut", "[costly]") {
  for (const LazOptions& options : some_layouts()) {
    INFO("point format " << options.point_format);
    const auto records = scan_records(options, 150, 1);
    const LazFile whole = encode_laz(options, records);
    for (std::size_t size = 0; size < whole.bytes.size(); ++size) {
      LazFile cut = whole;
      cut.bytes.resize(size);
      std::vector<std::uint8_t> read;
      if (!error_of(cut, read)) {
        // Only the last bytes of a stream or a table may carry nothing.
        CHECK(read == records);
        CHECK(size + 4 > whole.bytes.size());
      }
      CHECK(begins_with(records, read));
    }
  }
}

TEST_CASE("BytesChangedAreReadOrRefused", "[costly]") {
  std::mt19937_64 random(7);
  for (const LazOptions& options : some_layouts()) {
    INFO("point format " << options.point_format);
    LazFile file = encode_laz(options, scan_records(options, 150, 2));
    for (std::size_t at = file.data_offset; at < file.bytes.size(); at += 1 + random() % 5) {
      const std::byte before = file.bytes[at];
      file.bytes[at] ^= static_cast<std::byte>(1 + random() % 255);
      std::vector<std::uint8_t> read;
      if (!error_of(file, read)) CHECK(read.size() == 150 * record_bytes(options));
      file.bytes[at] = before;
    }
  }
}

TEST_CASE("TheFirstDamagedChunkIsToldOfWhateverTheThreads") {
  const LazOptions options{.point_format = 3, .compressor = 2, .chunk_points = 50};
  const auto records = scan_records(options, 500, 3);
  LazFile file = encode_laz(options, records);
  // A code that no encoder writes, in the streams of chunks 3 and 7.
  std::vector<std::size_t> begins;
  std::size_t at = file.data_offset + 8;
  for (std::size_t chunk = 0; chunk < 10; ++chunk) {
    begins.push_back(at);
    at += encode_pointwise_chunk(options, std::span(records).subspan(chunk * 50 * 34, 50 * 34))
              .size();
  }
  for (const std::size_t chunk : {3, 7})
    std::fill_n(file.bytes.begin() + static_cast<long>(begins[chunk] + 34), 4, std::byte{0xff});
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, 5);
  for (const int threads : {1, 2, 5}) {
    std::vector<std::uint8_t> read;
    const auto error = error_of(file, read, threads);
    REQUIRE(error);
    CHECK(error->parts().place == "byte " + std::to_string(begins[3] + 38));
    CHECK(read.size() == 150 * 34);
    CHECK(begins_with(records, read));
  }
}

TEST_CASE("ReadingOnAfterDamageIsRefusedAgain") {
  LazFile file =
      encode_laz({.point_format = 0, .compressor = 1}, std::vector<std::uint8_t>(20 * 50));
  file.points = 100000;
  OpenLaz laz(file);
  std::vector<std::byte> records(20 * 1000);
  const auto read_all = [&] {
    while (laz.reader.read(records) > 0) {
    }
  };
  CHECK_THROWS_AS(read_all(), Error);
  CHECK_THROWS_AS(read_all(), Error);
}

TEST_CASE("HugeCountsTakeNoMemory") {
  for (const LazOptions& options : some_layouts()) {
    LazFile file = encode_laz(options, scan_records(options, 150, 4));
    const std::uint64_t before = peak_memory_bytes();
    file.points = std::uint64_t{1} << 63;
    CHECK_THAT(message_of(file), Contains("byte "));
    file.points = ~std::uint64_t{0};
    CHECK_THAT(message_of(file), Contains("byte "));
    CHECK(peak_memory_bytes() - before < 50'000'000);
  }
}

void set32(LazFile& file, std::size_t at, std::uint32_t value) {
  store_little(file.bytes.data() + at, value);
}

TEST_CASE("ATableThatDoesNotFitTheFileIsRefused") {
  const LazOptions options{.point_format = 0, .compressor = 2};
  const LazFile file = encode_laz(options, scan_records(options, 1000, 5));
  const auto table = load_little<std::uint64_t>(&file.bytes[file.data_offset]);

  LazFile changed = file;
  set32(changed, table, 1);
  CHECK_THAT(message_of(changed),
             Contains("byte " + std::to_string(table)) && Contains("found version 1, expected 0"));
  changed = file;
  set32(changed, table + 4, 0xffffffffU);
  CHECK_THAT(message_of(changed), Contains("found 4294967295 chunks"));
  changed = file;
  set32(changed, table + 4, 9);
  CHECK_THAT(message_of(changed), Contains("found chunks for 900 points, expected 1000"));
  for (const std::uint64_t place : {std::uint64_t{3}, std::uint64_t{1} << 63, table + 1000}) {
    changed = file;
    store_little(&changed.bytes[file.data_offset], place);
    CHECK_THAT(message_of(changed), Contains("its place, byte " + std::to_string(place)));
  }
}

TEST_CASE("ChunksOfDifferentSizesCannotDoWithoutTheirTable") {
  LazOptions options{.point_format = 0, .compressor = 2, .chunk_points = 0};
  options.table = TablePlace::kMissing;
  CHECK_THAT(message_of(encode_laz(options, scan_records(options, 100, 6))),
             Contains("table of compressed chunks") && Contains("byte 37"));
}

TEST_CASE("ALayerLongerThanItsChunkIsRefused") {
  const LazOptions options{.point_format = 6, .compressor = 3};
  LazFile file = encode_laz(options, scan_records(options, 50, 7));
  set32(file, file.data_offset + 8 + 30 + 4 + 4 * 8, 0xfffffff0U);  // GPS times
  CHECK_THAT(message_of(file), Contains("layer 8 of 4294967280 bytes"));
}

TEST_CASE("PointsWithoutTheirFirstLayerAreRefused") {
  const LazOptions options{.point_format = 6, .compressor = 3};
  LazFile file = encode_laz(options, scan_records(options, 50, 8));
  for (std::size_t layer = 0; layer < 9; ++layer) set32(file, file.data_offset + 42 + 4 * layer, 0);
  CHECK_THAT(message_of(file), Contains("compressed points end too soon"));
}

LazFile with_description(unsigned at, std::uint16_t value) {
  LazFile file = encode_laz({.point_format = 3, .extra_bytes = 4}, {});
  store_little(file.vlr.data() + at, value);
  return file;
}

TEST_CASE("AnUnknownCompressionIsRefusedByName") {
  CHECK_THAT(message_of(with_description(0, 0)), Contains("found compressor 0"));
  CHECK_THAT(message_of(with_description(0, 4)), Contains("found compressor 4"));
  CHECK_THAT(message_of(with_description(2, 15)), Contains("found coder 15"));
  CHECK_THAT(message_of(with_description(34, 5)), Contains("found an item of type 5"));
  CHECK_THAT(message_of(with_description(34, 15)), Contains("found an item of type 15"));
  CHECK_THAT(message_of(with_description(38, 1)),
             Contains("found item POINT10 of version 1, expected 2"));
  CHECK_THAT(message_of(with_description(44, 3)), Contains("item GPSTIME11 of version 3"));
}

TEST_CASE("ADescriptionThatContradictsTheHeaderIsRefused") {
  CHECK_THAT(message_of(with_description(0, 3)), Contains("expected compressor 1 or 2"));
  CHECK_THAT(message_of(with_description(36, 21)), Contains("found item POINT10 of 21 bytes"));
  CHECK_THAT(message_of(with_description(54, 5)), Contains("found items of 39 bytes, expected 38"));
  CHECK_THAT(message_of(with_description(54, 0)), Contains("found item BYTE of 0 bytes"));
  CHECK_THAT(message_of(with_description(32, 2)), Contains("not those of point format 3"));
  CHECK_THAT(message_of(with_description(32, 5)), Contains("found 58 bytes, expected 5 items"));
  LazFile file = encode_laz({.point_format = 3}, {});
  file.options.point_format = 11;
  CHECK_THAT(message_of(file), Contains("point format 11"));
}

TEST_CASE("ADescriptionCutAnywhereIsRefused") {
  const LazFile whole = encode_laz({.point_format = 3, .extra_bytes = 4}, {});
  for (std::size_t size = 0; size < whole.vlr.size(); ++size) {
    LazFile cut = whole;
    cut.vlr.resize(size);
    CHECK_THAT(message_of(cut), Contains("the description of the compression is damaged"));
  }
}

}  // namespace
}  // namespace orbweave::test
