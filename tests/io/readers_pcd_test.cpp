#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <random>
#include <string_view>

#include "io/clouds/pcd_source.h"
#include "io/report/report.h"
#include "io/streams/lzf.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Catch::Contains;
using test::attribute_names;
using test::raw;
using test::read_cloud;
using test::reading_error;
using test::ScratchDirectory;
using test::write_file;

using Names = std::vector<std::string>;

PointCloud read_pcd(const std::string& content) {
  return read_all(
      *open_pcd_source(ByteReader(memory_byte_source(std::as_bytes(std::span(content)), "a.pcd"))));
}

std::string header(const std::string& fields, const std::string& sizes, const std::string& types,
                   const std::string& counts, const std::string& points, const std::string& data) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS " + fields + "\nSIZE " +
         sizes + "\nTYPE " + types + "\nCOUNT " + counts + "\nWIDTH " + points +
         "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + points + "\nDATA " + data + "\n";
}

std::string xyz_header(const std::string& points, const std::string& data) {
  return header("x y z", "4 4 4", "F F F", "1 1 1", points, data);
}

/// LZF by the simplest means: the last occurrence of the next three bytes, where it is near
/// enough; literals one run at a time.
std::string compress(const std::string& data) {
  constexpr std::size_t kReach = 8192;
  std::string out;
  std::string literals;
  std::map<std::string, std::size_t> last_seen;
  const auto flush = [&] {
    for (std::size_t i = 0; i < literals.size(); i += 32) {
      const std::string run = literals.substr(i, 32);
      out += static_cast<char>(run.size() - 1) + run;
    }
    literals.clear();
  };
  for (std::size_t i = 0; i < data.size();) {
    std::size_t length = 0;
    const auto seen = last_seen.find(data.substr(i, 3));
    const std::size_t from = seen == last_seen.end() ? i : seen->second;
    if (from != i && i - from <= kReach)
      while (length < 264 && i + length < data.size() && data[from + length] == data[i + length])
        ++length;
    if (length < 3) length = 0;
    const std::size_t end = i + std::max<std::size_t>(length, 1);
    if (length == 0) literals += data[i];
    for (; i < end; ++i)
      if (i + 3 <= data.size()) last_seen[data.substr(i, 3)] = i;
    if (length == 0) continue;
    flush();
    const std::size_t offset = end - length - from - 1;
    const std::size_t code = length - 2;
    out += static_cast<char>(std::min<std::size_t>(code, 7) << 5 | offset >> 8);
    if (code >= 7) out += static_cast<char>(code - 7);
    out += static_cast<char>(offset & 255);
  }
  flush();
  return out;
}

/// The body of a binary_compressed file.
std::string compressed_body(const std::string& columns) {
  const std::string packed = compress(columns);
  return raw(static_cast<std::uint32_t>(packed.size())) +
         raw(static_cast<std::uint32_t>(columns.size())) + packed;
}

std::vector<std::byte> decode(const std::string& packed, std::size_t size, std::size_t piece) {
  LzfDecoder decoder(size);
  const auto bytes = std::as_bytes(std::span(packed));
  std::size_t at = 0;
  for (std::size_t end = 0; end < bytes.size() && decoder.is_valid();) {
    end = std::min(end + piece, bytes.size());
    at += decoder.decode(bytes.subspan(at, end - at));
  }
  REQUIRE(decoder.is_valid());
  REQUIRE(at == bytes.size());
  return decoder.take();
}

bool is_valid_lzf(const std::string& packed, std::size_t limit) {
  LzfDecoder decoder(limit);
  decoder.decode(std::as_bytes(std::span(packed)));
  return decoder.is_valid();
}

void check_refused(const std::string& content, std::initializer_list<std::string> phrases) {
  const ScratchDirectory scratch;
  write_file(scratch / "a.pcd", content);
  const std::uint64_t before = peak_memory_bytes();
  const Error error = reading_error(scratch / "a.pcd");
  INFO(error.what());
  CHECK(error.kind() == ErrorKind::kBadInput);
  CHECK_THAT(error.what(), Contains("a.pcd"));
  for (const std::string& phrase : phrases) CHECK_THAT(error.what(), Contains(phrase));
  CHECK(peak_memory_bytes() - before < 50'000'000);
}

std::string from_hex(std::string_view hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16));
  return bytes;
}

}  // namespace

TEST_CASE("SamplePcdFilesHaveTheirPoints") {
  const auto path = [](const std::string& name) { return test::data_path("samples/pcd/" + name); };
  if (test::skipped_without(path("Zaghetto.pcd"))) return;
  const PointCloud portrait = read_cloud(path("Zaghetto.pcd"));
  CHECK(portrait.size() == 59750);
  CHECK(portrait.schema.position_type == ScalarType::kFloat32);
  CHECK(portrait.bounds().min == Vec3{static_cast<double>(0.17192f), static_cast<double>(0.42276f),
                                      static_cast<double>(0.50112f)});
  const PointCloud ascii = read_cloud(path("simple-ascii.pcd"));
  CHECK(ascii.size() == 213);
  // 4.2108e+06 is the float with the bits 0x4a8080e0.
  CHECK(attribute_names(ascii.schema) == Names{"red", "green", "blue"});
  CHECK(attribute_value(ascii, 0, 0) == 128.0);
  CHECK(attribute_value(ascii, 0, 1) == 128.0);
  CHECK(attribute_value(ascii, 0, 2) == 224.0);
}

TEST_CASE("UpperCaseFieldsOfAMapProjectionComeOutExactly") {
  const auto path = test::data_path("samples/pcd/autzen-utm.pcd");
  if (test::skipped_without(path)) return;
  const PointCloud cloud = read_cloud(path);
  CHECK(cloud.size() == 1065);
  CHECK(cloud.positions[0] == Vec3{494428.61, 4877455.58, 131.57});
  CHECK(cloud.bounds().max == Vec3{494993.68, 4878817.0200000005, 178.73});
  CHECK(attribute_names(cloud.schema) == Names{"intensity", "ReturnNumber", "NumberOfReturns",
                                               "ScanDirectionFlag", "EdgeOfFlightLine",
                                               "Classification", "ScanAngleRank", "UserData",
                                               "PointSourceId", "GpsTime", "red", "green", "blue"});
  CHECK(cloud.schema.attributes[9].type == ScalarType::kFloat64);
  CHECK(attribute_value(cloud, 0, 9) == 245380.78254962614);
  CHECK(attribute_value(cloud, 1, 12) == 68.0);
}

TEST_CASE("APcdCloudHasTheAttributesOfItsLasTwin") {
  // The same points in another projection.
  const auto path = test::data_path("samples/las/1.2-with-color.las");
  if (test::skipped_without(path)) return;
  const PointCloud las = read_cloud(path);
  const PointCloud pcd = read_cloud(test::data_path("samples/pcd/autzen-utm.pcd"));
  REQUIRE(pcd.size() == las.size());
  for (const auto& [pcd_name, las_name] :
       {std::pair("intensity", "intensity"), std::pair("red", "red"), std::pair("green", "green"),
        std::pair("blue", "blue"), std::pair("GpsTime", "gps_time"),
        std::pair("Classification", "classification")}) {
    INFO(las_name);
    for (std::size_t i = 0; i < pcd.size(); ++i)
      REQUIRE(test::value_of(pcd, i, pcd_name) == test::value_of(las, i, las_name));
  }
}

TEST_CASE("AsciiBinaryAndCompressedGiveTheSameBits") {
  // x y z, a normal, packed colours, three values of one field, padding, a double.
  const std::string fields = "x y z _ normal_x normal_y normal_z rgba shape time";
  const std::string sizes = "4 4 4 1 4 4 4 4 2 8";
  const std::string types = "F F F U F F F U I F";
  const std::string counts = "1 1 1 3 1 1 1 1 3 1";
  constexpr std::size_t kPoints = 5000;
  std::string text;
  std::string rows;
  std::vector<std::string> columns(10);
  for (std::size_t i = 0; i < kPoints; ++i) {
    const auto x = static_cast<float>(i % 50);
    const auto y = static_cast<float>(i / 50) * 0.25F;
    const auto color = static_cast<std::uint32_t>(0x80000000U + i * 1000);
    const auto shape = static_cast<std::int16_t>(i % 300);
    const double time = static_cast<double>(i) * 0.5 + 1e9;
    const std::vector<std::string> values = {
        raw(x),    raw(y),     raw(1.5F),
        "pad",     raw(0.0F),  raw(0.0F),
        raw(1.0F), raw(color), raw(shape) + raw(std::int16_t{-7}) + raw(std::int16_t{300}),
        raw(time)};
    for (std::size_t f = 0; f < values.size(); ++f) {
      rows += values[f];
      columns[f] += values[f];
    }
    text += std::to_string(x) + " " + std::to_string(y) + " 1.5 0 0 0 0 0 1 " +
            std::to_string(color) + " " + std::to_string(shape) + " -7 300 " +
            std::to_string(time) + "\n";
  }
  std::string whole;
  std::string without_padding;
  for (std::size_t f = 0; f < columns.size(); ++f) {
    whole += columns[f];
    if (f != 3) without_padding += columns[f];
  }
  const auto with = [&](const std::string& data) {
    return header(fields, sizes, types, counts, std::to_string(kPoints), data);
  };
  const PointCloud ascii = read_pcd(with("ascii") + text);
  CHECK(ascii.size() == kPoints);
  CHECK(ascii.schema.has_normals);
  CHECK(attribute_names(ascii.schema) ==
        Names{"red", "green", "blue", "alpha", "shape_0", "shape_1", "shape_2", "time"});
  CHECK(ascii.schema.attributes[4].type == ScalarType::kInt16);
  CHECK(ascii.positions[57] == Vec3{7, 0.25, 1.5});
  CHECK(ascii.normals[57] == Vec3{0, 0, 1});
  CHECK(attribute_value(ascii, 57, 1) == 0xde);  // 57000 is 0xdea8
  CHECK(attribute_value(ascii, 57, 2) == 0xa8);
  CHECK(attribute_value(ascii, 57, 3) == 0x80);
  CHECK(attribute_value(ascii, 57, 5) == -7.0);
  CHECK(attribute_value(ascii, 57, 7) == 1e9 + 28.5);
  CHECK(test::same_bits(read_pcd(with("binary") + rows), ascii));
  CHECK(test::same_bits(read_pcd(with("binary_compressed") + compressed_body(whole)), ascii));
  CHECK(test::same_bits(read_pcd(with("binary_compressed") + compressed_body(without_padding)),
                        ascii));
  const ScratchDirectory scratch;
  test::gzip_file(scratch / "a.pcd.gz", with("binary_compressed") + compressed_body(whole));
  CHECK(test::same_bits(read_cloud(scratch / "a.pcd.gz"), ascii));
  write_file(scratch / "a.xyz", with("ascii") + text);
  CHECK(test::same_bits(read_cloud(scratch / "a.xyz"), ascii));
}

TEST_CASE("ACompressedFileOfAnotherWriterIsRead") {
  // 24 points on a grid of half a unit, normals up, written by Open3D 0.19.
  const std::string body = from_hex(
      "a5000000a00200000100006000033f000080200300c0200360002007e0440fe00300205be003034067e003034083"
      "e00303010040e005030020200fe00303e0ff00e00f00e1035be0490b1fff800000f5800a00eb801400e1801e00d7"
      "802800cd803200c3803c00b98046001faf805000a5805a009b80640091806e00878078007d80820073808c006980"
      "96001f5f80a0005580aa004b80b4004180be003780c8002d80d2002380dc001980e600");
  const PointCloud cloud =
      read_pcd(header("x y z normal_x normal_y normal_z rgb", "4 4 4 4 4 4 4", "F F F F F F F",
                      "1 1 1 1 1 1 1", "24", "binary_compressed") +
               body);
  REQUIRE(cloud.size() == 24);
  for (std::size_t i = 0; i < 24; ++i) {
    const auto t = static_cast<double>(i);
    CHECK(cloud.positions[i] == Vec3{0.5 * static_cast<double>(i % 4), 0.5 * std::floor(t / 4), 0});
    CHECK(cloud.normals[i] == Vec3{0, 0, 1});
    CHECK(attribute_value(cloud, i, 0) == 10 * t);
    CHECK(attribute_value(cloud, i, 1) == 128.0);
    CHECK(attribute_value(cloud, i, 2) == 255 - 10 * t);
  }
}

TEST_CASE("LzfDecodesPiecesOfAnySize") {
  std::mt19937_64 random(3);
  std::string data;
  while (data.size() < 60000) {
    if (random() % 3 == 0) data += std::string(random() % 700, static_cast<char>(random() % 4));
    for (std::size_t i = random() % 90; i > 0; --i) data += static_cast<char>(random());
    if (data.size() > 9000) data += data.substr(data.size() - 1 - random() % 8192, random() % 500);
  }
  const std::string packed = compress(data);
  REQUIRE(packed.size() < data.size() / 2);
  const auto expected = std::as_bytes(std::span(data));
  for (const std::size_t piece : {std::size_t{1}, std::size_t{2}, std::size_t{7}, std::size_t{33},
                                  std::size_t{4096}, packed.size()}) {
    const std::vector<std::byte> decoded = decode(packed, data.size(), piece);
    CHECK(std::equal(decoded.begin(), decoded.end(), expected.begin(), expected.end()));
  }
}

TEST_CASE("LzfRefusesWhatReachesOutside") {
  using namespace std::string_literals;
  CHECK(
      is_valid_lzf("\x02"
                   "abc\x20\x02"s,
                   6));
  CHECK(decode("\x02"
               "abc\x20\x02"s,
               6, 6)
            .size() == 6);
  CHECK_FALSE(
      is_valid_lzf("\x02"
                   "abc\x20\x03"s,
                   6));  // four bytes back of three
  CHECK_FALSE(
      is_valid_lzf("\x02"
                   "abc\x20\x02"s,
                   5));  // one byte too long
  CHECK_FALSE(
      is_valid_lzf("\x02"
                   "abc"s,
                   2));                       // a literal too long
  CHECK_FALSE(is_valid_lzf("\x20\x00"s, 6));  // nothing to copy yet
  CHECK_FALSE(
      is_valid_lzf("\x00"
                   "a\xe0\xff\x00"s,
                   264));  // 265 bytes in all
  CHECK(decode("\x00"
               "a\xe0\xff\x00"s,
               265, 5) == std::vector<std::byte>(265, std::byte{'a'}));
  // What is cut off is left for the next piece.
  LzfDecoder decoder(10);
  const std::string cut =
      "\x02"
      "ab";
  CHECK(decoder.decode(std::as_bytes(std::span(cut))) == 0);
  CHECK(decoder.is_valid());
  CHECK(decoder.size() == 0);
}

TEST_CASE("PackedColorsMayBeFloatsOrIntegers") {
  const auto color_of = [](const std::string& name, const std::string& type,
                           const std::string& value) {
    const PointCloud cloud =
        read_pcd(header("x y z " + name, "4 4 4 4", "F F F " + type, "1 1 1 1", "1", "ascii") +
                 "1 2 3 " + value + "\n");
    std::vector<double> channels;
    for (std::size_t i = 0; i < cloud.schema.attributes.size(); ++i)
      channels.push_back(attribute_value(cloud, 0, i));
    return channels;
  };
  using Channels = std::vector<double>;
  CHECK(color_of("rgb", "U", "16711935") == Channels{255, 0, 255});
  CHECK(color_of("rgb", "U", "4294901760") == Channels{255, 0, 0});
  CHECK(color_of("rgb", "I", "-1") == Channels{255, 255, 255});
  CHECK(color_of("RGBA", "U", "2147549442") == Channels{1, 1, 2, 128});
  CHECK(color_of("rgb", "F", "2.3418052e-38") == Channels{255, 0, 0});
  CHECK(color_of("rgb", "F", "5.907955e-39") == Channels{64, 84, 250});  // not normalised
  CHECK(color_of("rgb", "F", "nan").size() == 3);
  // What is not packed stays as it is.
  const PointCloud plain = read_pcd(
      header("x y z rgb", "4 4 4 1", "F F F U", "1 1 1 3", "1", "ascii") + "1 2 3 4 5 6\n");
  CHECK(attribute_names(plain.schema) == Names{"rgb_0", "rgb_1", "rgb_2"});
}

TEST_CASE("PcdNormalsAndColorsAreKnownByTheNamesOfOtherFormats") {
  const PointCloud cloud =
      read_pcd(header("x y z NormalX NormalY NormalZ r g b", "4 4 4 4 4 4 1 1 1",
                      "F F F F F F U U U", "1 1 1 1 1 1 1 1 1", "1", "ascii") +
               "1 2 3 0 0 1 10 20 30\n");
  CHECK(cloud.normals == std::vector<Vec3>{{0, 0, 1}});
  CHECK(attribute_names(cloud.schema) == Names{"red", "green", "blue"});
  CHECK(attribute_value(cloud, 0, 2) == 30.0);
}

TEST_CASE("OldAndSparseHeadersAreRead") {
  const std::vector<Vec3> expected = {{1, 2, 3}, {4, 5, 6}};
  CHECK(read_pcd("VERSION .5\nCOLUMNS x y z\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n").positions ==
        expected);
  CHECK(read_pcd("# note\n\nFIELDS z y x\nSIZE 8 8 8\nTYPE F F F\nWIDTH 1\nHEIGHT 2\nDATA ascii\n"
                 "3 2 1\n\n6 5 4")
            .positions == expected);
  CHECK(read_pcd("VERSION 0.6\r\nFIELDS X Y Z\r\nSIZE 2 2 2\r\nTYPE I U I\r\nCOUNT 1 1 1\r\n"
                 "WIDTH 2\r\nDATA ascii\r\n1 2 3\r\n4 5 6\r\n")
            .positions == expected);
  CHECK(read_pcd("FIELDS x y z\nPOINTS 0\nDATA ascii\n").empty());
  CHECK(read_pcd("FIELDS x y z\nPOINTS 0\nDATA binary_compressed\n").empty());
}

TEST_CASE("MissingPointsOfAnOrganisedCloudPassThrough") {
  const PointCloud cloud = read_pcd(
      "FIELDS x y z\nWIDTH 2\nHEIGHT 2\nPOINTS 4\nDATA ascii\n1 2 3\nnan nan nan\n4 5 6\n7 8 9\n");
  REQUIRE(cloud.size() == 4);
  CHECK(std::isnan(cloud.positions[1].y));
}

TEST_CASE("AViewpointIsWhereTheScannerStood") {
  const auto scanner_of = [](const std::string& viewpoint) {
    const std::string content =
        "FIELDS x y z\nWIDTH 1\nHEIGHT 1\n" + viewpoint + "POINTS 1\nDATA ascii\n1 2 3\n";
    const auto source =
        open_pcd_source(ByteReader(memory_byte_source(std::as_bytes(std::span(content)), "a.pcd")));
    // The points stay where they are.
    CHECK(read_all(*source).positions == std::vector<Vec3>{{1, 2, 3}});
    return source->scanner();
  };
  CHECK_FALSE(scanner_of(""));
  CHECK_FALSE(scanner_of("VIEWPOINT 0 0 0 1 0 0 0\n"));
  CHECK(scanner_of("VIEWPOINT 1.5 -2 3e3 1 0 0 0\n") == ScannerPlace{{1.5, -2, 3000}});
  CHECK(scanner_of("VIEWPOINT 0 0 0 0.5 0.5 0.5 0.5\n") == ScannerPlace{{0, 0, 0}});
}

TEST_CASE("DamagedPcdHeadersNameTheirLine") {
  check_refused("1 2 3\n4 5 6\n", {"line 1", "no line of a PCD header", "\"1\"", "FIELDS"});
  check_refused("\"\" x y z\n", {"line 1", "no line of a PCD header"});
  check_refused("VERSION 0.9\nFIELDS x y z\nPOINTS 1\nDATA ascii\n1 2 3\n", {"line 1", "\"0.9\""});
  check_refused("FIELDS x y z\nPOINTS 1\n", {"header has no end", "DATA"});
  check_refused("POINTS 1\nDATA ascii\n1 2 3\n", {"no line FIELDS"});
  check_refused("FIELDS x y\nPOINTS 1\nDATA ascii\n1 2\n", {"have no z"});
  check_refused("FIELDS x y z\nFIELDS x y z\nPOINTS 1\nDATA ascii\n", {"line 2", "two lines"});
  check_refused("FIELDS x y z\nSIZE 4 4\nPOINTS 1\nDATA ascii\n", {"line 2", "SIZE", "2 values"});
  check_refused("FIELDS x y z\nSIZE 4 4 3\nPOINTS 1\nDATA ascii\n", {"unknown type", "\"3\""});
  check_refused("FIELDS x y z\nSIZE 4 4 2\nTYPE F F F\nPOINTS 1\nDATA ascii\n",
                {"line 3", "\"2\""});
  check_refused("FIELDS x y z\nPOINTS -1\nDATA ascii\n", {"line 2", "no count", "\"-1\""});
  check_refused("FIELDS x y z\nDATA ascii\n1 2 3\n", {"how many points"});
  check_refused("FIELDS x y z\nPOINTS 1\nDATA zipped\n", {"line 3", "\"zipped\"", "binary"});
  check_refused("FIELDS x y z\nPOINTS\nDATA ascii\n", {"line 2", "POINTS has no value"});
  check_refused("FIELDS x y z X\nPOINTS 1\nDATA ascii\n1 2 3 4\n", {"one name", "\"x\""});
  check_refused("FIELDS x y z\nVIEWPOINT 0 0 0\nPOINTS 1\nDATA ascii\n1 2 3\n",
                {"line 2", "no viewpoint"});
  check_refused("FIELDS x y z\nWIDTH 2\nHEIGHT 2\nPOINTS 3\nDATA ascii\n1 2 3\n",
                {"line 4", "WIDTH times HEIGHT", "3", "2 x 2"});
  check_refused("FIELDS x y z\nWIDTH 4294967296\nHEIGHT 4294967296\nPOINTS 0\nDATA ascii\n",
                {"WIDTH times HEIGHT"});
  check_refused("FIELDS x y z d\nCOUNT 1 1 1 9223372036854775808\nPOINTS 1\nDATA ascii\n1 2 3\n",
                {"line 2", "number of values"});
  check_refused("FIELDS x y z d\nCOUNT 1 1 1 5000\nPOINTS 1\nDATA ascii\n1 2 3\n",
                {"line 2", "too many values"});
}

TEST_CASE("SamplePcdWithoutHeaderIsRefused") {
  const auto path = test::data_path("samples/corrupt/missingheader.pcd");
  if (test::skipped_without(path)) return;
  CHECK_THAT(reading_error(path).what(), Contains("line 1: this is no line of a PCD header"));
}

TEST_CASE("PcdFilesThatEndEarlyAreRefused") {
  check_refused("", {"empty"});
  for (const char* data : {"ascii", "binary", "binary_compressed"}) {
    check_refused(xyz_header("2", data), {"shorter than its header says"});
    check_refused(xyz_header("9223372036854775808", data) + std::string(100, '1'), {});
  }
  const std::string twelve(12, 'a');
  check_refused(xyz_header("2", "binary") + twelve + "abc", {"15 bytes", "2 points of 12 bytes"});
  check_refused(xyz_header("2", "ascii") + "1.000 2 3\n1 2", {"line 13", "2 values"});
  check_refused(xyz_header("2", "ascii") + "1.00000000 2 3\n",
                {"shorter", "line 12", "found 1 point, expected 2 points"});
  check_refused(xyz_header("9223372036854775808", "ascii") + "1 2 3\n",
                {"shorter", "9223372036854775808 points"});
  const ScratchDirectory scratch;  // where the length is not known beforehand
  test::gzip_file(scratch / "a.pcd.gz", xyz_header("9223372036854775808", "binary") + twelve);
  const std::uint64_t before = peak_memory_bytes();
  CHECK_THAT(reading_error(scratch / "a.pcd.gz").what(), Contains("shorter"));
  CHECK(peak_memory_bytes() - before < 50'000'000);
}

TEST_CASE("DamagedCompressedPointsAreRefused") {
  const std::string columns(2400, '\0');  // 200 points
  const std::string front = xyz_header("200", "binary_compressed");
  const std::string body = compressed_body(columns);
  CHECK(read_pcd(front + body).size() == 200);
  check_refused(front + body.substr(0, 5), {"no sizes"});
  check_refused(front + body.substr(0, body.size() - 1), {"shorter", "compressed bytes"});
  check_refused(front + raw(4U) + body.substr(4), {"cannot be true", "4 bytes for 2400"});
  check_refused(front + body.substr(0, 4) + raw(2412U) + body.substr(8),
                {"does not match the header", "2412 bytes", "200 points of 12 bytes"});
  // Sizes as they should be, content not.
  std::string reaching = body;
  reaching[10] = '\x3f';
  reaching[11] = '\xff';
  check_refused(front + reaching, {"compressed points are damaged"});
  const std::string other = compress(std::string(1200, '\0') + std::string(1199, '\1'));
  check_refused(front + raw(static_cast<std::uint32_t>(other.size())) + raw(2400U) + other,
                {"compressed points are damaged", "2399 bytes"});
  // 2^63 points need more bytes than a compressed file can speak of.
  check_refused(xyz_header("9223372036854775808", "binary_compressed") + body,
                {"does not match the header"});
  // 4 GB claimed by a small file.
  check_refused(xyz_header("357913941", "binary_compressed") + raw(100U) + raw(4294967292U) +
                    std::string(100, '\0'),
                {"cannot be true"});
}

TEST_CASE("PcdFilesThatGoOnAreRefused") {
  check_refused(xyz_header("1", "ascii") + "1 2 3\n4 5 6\n",
                {"goes on", "expected the end of the file after 1 point"});
  check_refused(xyz_header("1", "binary") + std::string(24, 'a'),
                {"goes on", "expected the end of the file after 1 point"});
  CHECK(read_pcd(xyz_header("1", "binary") + std::string(12, 'a') + std::string(4, '\0')).size() ==
        1);
}

TEST_CASE("PcdTextThatDoesNotFitNamesItsLine") {
  check_refused(xyz_header("2", "ascii") + "1 2 3\n1 two 3\n", {"line 13, column 2", "\"two\""});
  check_refused(xyz_header("2", "ascii") + "1 2 3\n1 2 3 4\n", {"line 13", "4 values"});
  check_refused(header("x y z i", "4 4 4 1", "F F F U", "1 1 1 1", "1", "ascii") + "1 2 3 256\n",
                {"line 12, column 4", "0 to 255", "(i)"});
}

}  // namespace orbweave
