// Points of LAS files of every version and format, and files that are damaged.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "io/clouds/scan_source.h"
#include "io/points/point_views.h"
#include "tests/io/las_files.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using test::las_error;
using test::las_source;
using test::LasFile;
using test::LasPoint;
using test::read_las;
using test::typed_names;
using test::value_of;

using Names = std::vector<std::string>;

/// Any point that the format can hold, not withheld.
LasPoint any_point(std::mt19937_64& random, int format) {
  const auto bits = [&](int count) { return static_cast<unsigned>(random() >> (64 - count)); };
  LasPoint p;
  for (std::int32_t& v : p.xyz) v = static_cast<std::int32_t>(bits(32));
  p.intensity = static_cast<std::uint16_t>(bits(16));
  p.return_number = bits(format < 6 ? 3 : 4);
  p.number_of_returns = bits(format < 6 ? 3 : 4);
  p.scan_direction = bits(1) != 0;
  p.edge_of_flight_line = bits(1) != 0;
  p.classification = bits(format < 6 ? 5 : 8);
  p.synthetic = bits(1) != 0;
  p.key_point = bits(1) != 0;
  p.overlap = bits(1) != 0;
  p.scanner_channel = bits(2);
  p.scan_angle = static_cast<std::int16_t>(bits(16));
  p.user_data = static_cast<std::uint8_t>(bits(8));
  p.point_source_id = static_cast<std::uint16_t>(bits(16));
  p.gps_time = static_cast<double>(bits(32)) / 1024.0;
  for (std::uint16_t& v : p.rgb_nir) v = static_cast<std::uint16_t>(bits(16));
  return p;
}

std::vector<LasPoint> any_points(int format, std::size_t count) {
  std::mt19937_64 random(static_cast<std::uint64_t>(format) + 1);
  std::vector<LasPoint> points;
  for (std::size_t i = 0; i < count; ++i) points.push_back(any_point(random, format));
  return points;
}

LasFile file_of(int minor, int format, const std::vector<LasPoint>& points) {
  LasFile file{.minor = minor, .format = format};
  for (const LasPoint& point : points) file.add(point);
  return file;
}

LasFile small_file(int minor = 2, int format = 0, std::size_t count = 3) {
  return file_of(minor, format, any_points(format, count));
}

Names expected_names(int format) {
  Names names = {"intensity uint16", "return_number uint8", "number_of_returns uint8",
                 "classification uint8"};
  const Names rest = format < 6 ? Names{"scan_angle_rank int8", "user_data uint8"}
                                : Names{"user_data uint8", "scan_angle int16"};
  names.insert(names.end(), rest.begin(), rest.end());
  names.push_back("point_source_id uint16");
  if (test::has_gps_time(format)) names.push_back("gps_time float64");
  if (test::has_colours(format))
    names.insert(names.end(), {"red uint16", "green uint16", "blue uint16"});
  if (test::has_infrared(format)) names.push_back("nir uint16");
  return names;
}

void check_attributes(const PointCloud& cloud, std::size_t i, int format, const LasPoint& p) {
  CHECK(value_of(cloud, i, "intensity") == p.intensity);
  CHECK(value_of(cloud, i, "return_number") == p.return_number);
  CHECK(value_of(cloud, i, "number_of_returns") == p.number_of_returns);
  CHECK(value_of(cloud, i, "classification") == p.classification);
  if (format < 6)
    CHECK(value_of(cloud, i, "scan_angle_rank") == static_cast<std::int8_t>(p.scan_angle));
  else
    CHECK(value_of(cloud, i, "scan_angle") == p.scan_angle);
  CHECK(value_of(cloud, i, "user_data") == p.user_data);
  CHECK(value_of(cloud, i, "point_source_id") == p.point_source_id);
  if (test::has_gps_time(format)) CHECK(value_of(cloud, i, "gps_time") == p.gps_time);
  if (test::has_colours(format)) {
    CHECK(value_of(cloud, i, "red") == p.rgb_nir[0]);
    CHECK(value_of(cloud, i, "green") == p.rgb_nir[1]);
    CHECK(value_of(cloud, i, "blue") == p.rgb_nir[2]);
  }
  if (test::has_infrared(format)) CHECK(value_of(cloud, i, "nir") == p.rgb_nir[3]);
}

TEST_CASE("EveryPointFormatOfEveryVersionComesBackWhole") {
  constexpr std::array<int, 5> kLastFormat = {1, 1, 3, 5, 10};
  for (int minor = 0; minor <= 4; ++minor) {
    for (int format = 0; format <= kLastFormat[static_cast<std::size_t>(minor)]; ++format) {
      CAPTURE(minor, format);
      const std::vector<LasPoint> points = any_points(format, 40);
      LasFile file = file_of(minor, format, points);
      file.gap = std::string(2, '\xdd');  // LAS 1.0 puts a signature there
      const PointCloud cloud = read_las(file.bytes());
      REQUIRE(cloud.size() == points.size());
      CHECK(typed_names(cloud.schema) == expected_names(format));
      CHECK_FALSE(cloud.schema.has_normals);
      for (std::size_t i = 0; i < points.size(); ++i) {
        check_attributes(cloud, i, format, points[i]);
        for (int axis = 0; axis < 3; ++axis)
          CHECK(cloud.positions[i][axis] ==
                points[i].xyz[static_cast<std::size_t>(axis)] * 0.01 + 0.0);
      }
    }
  }
}

TEST_CASE("CoordinatesAreIntegerTimesScalePlusOffsetToTheLastBit") {
  for (const double factor : {1e-6, 1.0, 1e6}) {
    LasFile file = small_file(2, 0, 200);
    file.scale = {0.00025 * factor, 0.001 * factor, -0.01 * factor};
    file.offset = {515396.0 * factor, 4918348.3 * factor, -1e9 * factor};
    const PointCloud cloud = read_las(file.bytes());
    const std::vector<LasPoint> points = any_points(0, 200);
    REQUIRE(cloud.size() == points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        // Stored in between, so that no compiler joins the two steps.
        volatile double scaled = points[i].xyz[axis] * file.scale[axis];
        volatile double moved = scaled + file.offset[axis];
        CHECK(cloud.positions[i][static_cast<int>(axis)] == moved);
      }
    }
  }
}

TEST_CASE("BatchesOfAnySizeMakeTheSameCloud") {
  const std::string bytes = small_file(4, 7, 9000).bytes();
  const PointCloud whole = read_las(bytes);
  REQUIRE(whole.size() == 9000);
  for (const std::size_t capacity : {std::size_t{1}, std::size_t{7}, std::size_t{4096},
                                     std::numeric_limits<std::size_t>::max()}) {
    const auto source = las_source(bytes);
    PointCloud cloud, batch;
    cloud.schema = source->schema();
    while (source->read(batch, capacity)) {
      CHECK(batch.size() <= capacity);
      cloud.append(batch);
    }
    CHECK(test::same_bits(cloud, whole));
    CHECK(source->bytes_read() == bytes.size());
    CHECK_FALSE(source->read(batch, capacity));
    CHECK(batch.empty());
  }
}

TEST_CASE("TwoThreadsReadTheSameFileAtOnce") {
  const test::ScratchDirectory scratch;
  test::write_file(scratch / "CLOUD.LAS", small_file(2, 3, 20000).bytes());
  const PointCloud alone = test::read_cloud(scratch / "CLOUD.LAS");
  REQUIRE(alone.size() == 20000);
  std::array<PointCloud, 2> clouds;
  std::thread first([&] { clouds[0] = test::read_cloud(scratch / "CLOUD.LAS"); });
  std::thread second([&] { clouds[1] = test::read_cloud(scratch / "CLOUD.LAS"); });
  first.join();
  second.join();
  CHECK(test::same_bits(clouds[0], alone));
  CHECK(test::same_bits(clouds[1], alone));
}

TEST_CASE("PointsAreSelectedAlikeWhereAttributesAreNotDecoded") {
  ScanOptions options;
  options.dropped_classes = {1, 7, 11};
  options.returns = ReturnFilter::kLast;
  options.scanners = {parse_scanner_of_value("PointSourceId=5 0 0 9")};
  options.with_view = true;
  for (const int format : {1, 7}) {
    std::vector<LasPoint> points = any_points(format, 400);
    for (std::size_t i = 0; i < points.size(); ++i)
      points[i].point_source_id = static_cast<std::uint16_t>(i % 7);
    const std::string bytes = file_of(4, format, points).bytes();
    const auto selected = [&](bool without) {
      options.without_attributes = without;
      const auto source = open_scan_source(las_source(bytes), options, "a.las");
      return std::pair{read_all(*source), source->left_out()};
    };
    const auto [all, all_left_out] = selected(false);
    const auto [few, few_left_out] = selected(true);
    REQUIRE(few.size() > 50);
    REQUIRE(few.size() < 350);
    CHECK(few.positions == all.positions);
    CHECK(few_left_out == all_left_out);
    CHECK(few.schema.attributes == view_fields());
    for (std::size_t i = 0; i < few.size(); ++i)
      for (const AttributeField& view : view_fields())
        REQUIRE(value_of(few, i, view.name) == value_of(all, i, view.name));
  }
}

TEST_CASE("WithheldPointsAreLeftOutAndCounted") {
  for (const int format : {0, 5, 6, 10}) {
    std::vector<LasPoint> points = any_points(format, 5000);
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].withheld = i < 4000 ? i % 3 == 0 : true;  // whole blocks of them too
      if (!points[i].withheld) kept.push_back(i);
    }
    const std::string bytes = file_of(4, format, points).bytes();
    const auto source = las_source(bytes);
    CHECK(source->left_out().empty());
    const PointCloud cloud = read_all(*source);
    REQUIRE(cloud.size() == kept.size());
    for (std::size_t k = 0; k < kept.size(); k += 97)
      check_attributes(cloud, k, format, points[kept[k]]);
    CHECK(source->left_out() == DroppedPoints{{"withheld", points.size() - kept.size()}});
    CHECK(source->declared_points() == points.size());
  }
}

TEST_CASE("UpperBitsOfTheClassWithholdNothingInVersion10") {
  std::vector<LasPoint> points = any_points(1, 4);
  for (LasPoint& point : points) point.withheld = true;
  const std::string bytes = file_of(0, 1, points).bytes();
  const auto source = las_source(bytes);
  CHECK(read_all(*source).size() == 4);
  CHECK(source->left_out().empty());
}

TEST_CASE("TheCountOf64BitsWinsOverTheLegacyCount") {
  LasFile file = small_file(4, 3, 5);
  for (const std::uint32_t legacy : {0u, 3u, 5u, 4000000000u}) {
    file.legacy_points = legacy;
    CHECK(read_las(file.bytes()).size() == 5);
  }
  file.legacy_points = 5;  // as writers do that fill in nothing but this one
  file.points = 0;
  CHECK(read_las(file.bytes()).size() == 5);
}

TEST_CASE("PointsBeyondTheCountAreNotRead") {
  LasFile file = small_file(2, 0, 5);
  file.legacy_points = 3;
  file.tail = "half a record";
  const std::string bytes = file.bytes();
  const auto source = las_source(bytes);
  CHECK(source->declared_points() == 3u);
  CHECK(read_all(*source).size() == 3);
  CHECK(source->facts().left_out ==
        std::vector<std::string>{"bytes of 2 points behind those that the header counts"});
}

TEST_CASE("WhatIsNoPointBehindThoseCountedIsNotTakenForOne") {
  const auto left_out = [](const LasFile& file) {
    const std::string bytes = file.bytes();
    return las_source(bytes)->facts().left_out;
  };
  LasFile file = small_file(2, 0, 5);
  CHECK(left_out(file).empty());
  file.tail = std::string(19, 'x');  // a byte less than a point
  CHECK(left_out(file).empty());
  file.tail = std::string(4096, '\0');
  CHECK(left_out(file).empty());
  file.legacy_points = 0;  // as a program leaves it that was ended
  CHECK(left_out(file) ==
        std::vector<std::string>{"bytes of 209 points behind those that the header counts"});
  LasFile waves = small_file(3, 4, 5);
  waves.tail = std::string(4096, 'x');
  CHECK(left_out(waves).empty());
}

TEST_CASE("BytesThatNothingDescribesAreSkipped") {
  std::vector<LasPoint> points = any_points(3, 6);
  const PointCloud plain = read_las(file_of(2, 3, points).bytes());
  for (LasPoint& point : points) point.extra = "12345";
  CHECK(test::same_bits(read_las(file_of(2, 3, points).bytes()), plain));
}

TEST_CASE("AHeaderAloneIsAnEmptyCloud") {
  for (int minor = 0; minor <= 4; ++minor) {
    LasFile file{.minor = minor};
    file.scale = {0, 0, 0};  // nobody asks
    const std::string bytes = file.bytes();
    const auto source = las_source(bytes);
    PointCloud batch;
    CHECK(source->declared_points() == 0u);
    CHECK_FALSE(source->read(batch, 10));
    CHECK(batch.schema == source->schema());
  }
}

/// The message must hold all of these.
void check_refused(const std::string& bytes, const Names& words) {
  const Error error = las_error(bytes);
  CHECK(error.kind() == ErrorKind::kBadInput);
  CHECK(error.parts().file == "test.las");
  const std::string message = error.what();
  CAPTURE(message);
  for (const std::string& word : words) CHECK(message.find(word) != std::string::npos);
}

TEST_CASE("AFileCutAnywhereIsRefused") {
  for (const int minor : {2, 4}) {
    const std::string bytes = small_file(minor, 0, 2).bytes();
    REQUIRE(las_error(bytes).kind() == ErrorKind::kNone);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      CAPTURE(minor, length);
      const Error error = las_error(bytes.substr(0, length));
      CHECK(error.kind() == ErrorKind::kBadInput);
      CHECK_FALSE(error.parts().place.empty());
    }
  }
  check_refused("", {"no LAS file", "byte 0"});
  check_refused(small_file(2, 0, 2).bytes().substr(0, 226), {"ends within the LAS header", "227"});
  const std::string two = small_file(2, 0, 2).bytes();
  check_refused(two.substr(0, two.size() - 1),
                {"too short", "room for 1 (39 bytes", "2 points of 20"});
}

TEST_CASE("CountsThatNoFileHoldsAreRefusedWithBothNumbers") {
  LasFile file = small_file(4, 6, 3);
  file.points = std::uint64_t{1} << 63;
  check_refused(file.bytes(),
                {"byte 247", "room for 3 ", "9223372036854775808 points of 30 bytes"});
  file.points = std::numeric_limits<std::uint64_t>::max();
  check_refused(file.bytes(), {"18446744073709551615 points"});
  LasFile old = small_file(2, 0, 3);
  old.legacy_points = 0xffffffffu;
  check_refused(old.bytes(), {"byte 107", "4294967295 points of 20 bytes"});
}

TEST_CASE("FieldsOfTheHeaderThatCannotBeAreNamed") {
  const auto refused = [](auto change, const Names& words) {
    LasFile file = small_file(4, 1, 3);
    change(file);
    check_refused(file.bytes(), words);
  };
  refused([](LasFile& f) { f.minor = 5; }, {"version", "1.5", "1.0 to 1.4"});
  refused([](LasFile& f) { f.header_bytes = 227; }, {"header", "227 bytes", "375"});
  refused([](LasFile& f) { f.point_data_offset = 374; }, {"byte 96", "byte 374"});
  refused([](LasFile& f) { f.point_data_offset = 0xffffffffu; }, {"byte 96", "byte 4294967295"});
  refused([](LasFile& f) { f.stored_format = 11; }, {"point format", "11", "0 to 10"});
  refused([](LasFile& f) { f.stored_format = 0x41; }, {"compression", "65"});
  refused([](LasFile& f) { f.record_bytes = 27; }, {"27 bytes", "at least 28"});
  refused([](LasFile& f) { f.record_bytes = 0; }, {"0 bytes", "at least 28"});
  refused([](LasFile& f) { f.scale[1] = 0.0; }, {"scale of y", "byte 139"});
  refused([](LasFile& f) { f.scale[0] = std::nan(""); }, {"scale of x", "nan"});
  refused([](LasFile& f) { f.offset[2] = -HUGE_VAL; }, {"offset of z", "byte 171", "-inf"});
  std::string other = small_file().bytes();
  other[24] = 2;
  check_refused(other, {"version", "2.2"});
  check_refused("ply\nformat ascii 1.0\n", {"no LAS file", "\"LASF\""});
}

TEST_CASE("ListsOfVariableRecordsThatLieDoNotHideThePoints") {
  for (const std::uint32_t count : {0u, 1u, 3u, 0xffffffffu}) {
    LasFile file = small_file(2, 0, 5);
    file.variable_records = {test::variable_record("someone", 1, "payload")};
    file.variable_record_count = count;
    CHECK(read_las(file.bytes()).size() == 5);
  }
  LasFile longer = small_file(2, 0, 5);
  longer.variable_records = {test::variable_record("LASF_Spec", 4, "abc")};
  longer.variable_records[0][20] = '\xff';  // its length reaches into the points
  CHECK(read_las(longer.bytes()).size() == 5);
}

TEST_CASE("ExtendedRecordsThatLieDoNotHideThePoints") {
  LasFile file = small_file(4, 6, 5);
  file.extended_records = {test::variable_record("someone", 1, "payload", true)};
  for (const std::uint64_t offset : {std::uint64_t{0}, std::uint64_t{380}, std::uint64_t{1} << 63,
                                     std::numeric_limits<std::uint64_t>::max()}) {
    file.extended_offset = offset;
    CHECK(read_las(file.bytes()).size() == 5);
  }
  LasFile longer = small_file(4, 6, 5);
  longer.extended_records = {test::variable_record("LASF_Projection", 2112, "abc", true)};
  longer.extended_records[0].replace(20, 8, test::raw(std::uint64_t{1} << 63));
  const std::string bytes = longer.bytes();
  CHECK(las_source(bytes)->coordinate_system().empty());
  CHECK(read_las(bytes).size() == 5);
}

TEST_CASE("ALasFileTellsItsVersionItsPointFormatAndItsProgram") {
  LasFile file{.minor = 3, .format = 4};
  file.add({});
  std::string bytes = file.bytes();
  bytes.replace(58, 32, "some program" + std::string(20, '\0'));
  const double largest = 7.5;
  bytes.replace(179, 8, test::raw(largest));
  const FileFacts facts = las_source(bytes)->facts();
  CHECK(facts.format == "LAS");
  CHECK(facts.version == "1.3");
  CHECK(facts.point_format == 4);
  CHECK(facts.software == "some program");
  CHECK(facts.declared_bounds->max.x == 7.5);
}

TEST_CASE("OpeningByNameTellsWhatCannotBe") {
  const test::ScratchDirectory scratch;
  const std::string bytes = small_file().bytes();
  test::write_file(scratch / "empty.las", "");
  CHECK(test::reading_error(scratch / "empty.las").kind() == ErrorKind::kBadInput);
  test::gzip_file(scratch / "packed.las.gz", bytes);
  const std::string packed = test::reading_error(scratch / "packed.las.gz").what();
  CHECK(packed.find("gunzip") != std::string::npos);
  CHECK(test::reading_error(scratch / "absent.las").kind() == ErrorKind::kBadInput);
  test::write_file(scratch / "cloud.abc", bytes);
  const std::string unknown = test::reading_error(scratch / "cloud.abc").what();
  CHECK(unknown.find(".las") != std::string::npos);
  CHECK(unknown.find(".laz") != std::string::npos);
  test::write_file(scratch / "cloud.txt", bytes);
  const std::string text = test::reading_error(scratch / "cloud.txt").what();
  CHECK(text.find("a file named .las or .laz") != std::string::npos);
}

}  // namespace
}  // namespace orbweave
