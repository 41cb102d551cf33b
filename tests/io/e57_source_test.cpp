// E57 clouds whose every value is known, encoded here.
#include "io/clouds/e57/e57_source.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "io/clouds/e57/crc32c.h"
#include "io/clouds/scan_source.h"
#include "tests/io/e57_files.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave::test {
namespace {

constexpr const char* kNormals = "xmlns:nor=\"http://www.libe57.org/E57_NOR_surface_normals.txt\"";

/// A pose that turns by 90 degrees about z, x to y, and then moves by (10, 20, 30).
constexpr const char* kQuarterTurn =
    "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">0.5</w>"
    "<x type=\"Float\"/><y type=\"Float\"/><z type=\"Float\">0.5</z></rotation>"
    "<translation type=\"Structure\"><x type=\"Float\">10</x><y type=\"Float\">20</y>"
    "<z type=\"Float\">30</z></translation></pose>";

std::uint32_t crc_of(const std::string& bytes) { return crc32c(std::as_bytes(std::span(bytes))); }

/// `count` integers spread over all of [minimum, maximum], its ends among them.
std::vector<std::int64_t> spread(std::int64_t minimum, std::int64_t maximum, std::size_t count) {
  std::mt19937_64 random(7);
  const std::uint64_t range =
      static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(minimum);
  std::vector<std::int64_t> values = {minimum, maximum};
  while (values.size() < count) {
    const std::uint64_t step = range + 1 == 0 ? random() : random() % (range + 1);
    values.push_back(static_cast<std::int64_t>(static_cast<std::uint64_t>(minimum) + step));
  }
  return values;
}

std::vector<Vec3> some_points(std::size_t count) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = static_cast<double>(i);
    points.push_back({at / 3.0, -at * 1e6, 1.0 / (at + 1.0)});
  }
  return points;
}

E57Scan3D scan_of(const std::vector<Vec3>& points) {
  E57Scan3D scan;
  scan.columns = cartesian(points);
  return scan;
}

PointCloud read_scan(const E57Scan3D& scan, const std::string& root_attributes = {}) {
  return read_e57(make_e57({.scans = {scan}, .root_attributes = root_attributes}));
}

bool has(const PointCloud& cloud, const std::string& name, ScalarType type) {
  const auto& fields = cloud.schema.attributes;
  return std::find(fields.begin(), fields.end(), AttributeField{name, type}) != fields.end();
}

double distance(Vec3 a, Vec3 b) { return norm(a - b); }

}  // namespace

TEST_CASE("Crc32cGivesTheVectorsOfRfc3720") {
  std::string ascending, descending;
  for (int i = 0; i < 32; ++i) ascending += static_cast<char>(i);
  descending.assign(ascending.rbegin(), ascending.rend());
  CHECK(crc_of("") == 0u);
  CHECK(crc_of("123456789") == 0xE3069283u);
  CHECK(crc_of(std::string(32, '\0')) == 0x8A9136AAu);
  CHECK(crc_of(std::string(32, '\xFF')) == 0x62A8AB43u);
  CHECK(crc_of(ascending) == 0x46DD794Eu);
  CHECK(crc_of(descending) == 0x113FDB5Cu);
}

TEST_CASE("E57IntegersOfEveryWidthComeOutHoweverPacketsSplitThem") {
  for (unsigned bits = 1; bits <= 64; ++bits) {
    const std::int64_t minimum = bits < 64 ? -5 : std::numeric_limits<std::int64_t>::min();
    const std::uint64_t states = bits < 64 ? (std::uint64_t{1} << bits) - 1 : ~std::uint64_t{0};
    const auto maximum = static_cast<std::int64_t>(static_cast<std::uint64_t>(minimum) + states);
    const std::vector<std::int64_t> values = spread(minimum, maximum, 101);
    E57Scan3D scan = scan_of(some_points(values.size()));
    scan.columns.push_back(integers("intensity", minimum, maximum, values));
    for (const std::size_t bytes : {1, 3, 7, 64, 4096}) {
      scan.packet_bytes = {8 * bytes, 8 * bytes + 3, 4096, bytes};
      const PointCloud cloud = read_scan(scan);
      INFO(bits << " bits, " << bytes << " bytes of them per packet");
      REQUIRE(cloud.size() == values.size());
      CHECK(cloud.positions == some_points(values.size()));
      for (std::size_t i = 0; i < values.size(); ++i)
        REQUIRE(value_of(cloud, i, "intensity") == static_cast<double>(values[i]));
    }
  }
}

TEST_CASE("E57IntegersOf64BitsLoseNothing") {
  const std::vector<std::int64_t> values = {std::numeric_limits<std::int64_t>::min(), -1, 0,
                                            (std::int64_t{1} << 53) + 1,
                                            std::numeric_limits<std::int64_t>::max()};
  E57Scan3D scan = scan_of(some_points(values.size()));
  scan.columns.push_back(integers("intensity", values.front(), values.back(), values));
  const PointCloud cloud = read_scan(scan);
  REQUIRE(has(cloud, "intensity", ScalarType::kInt64));
  REQUIRE(cloud.attributes.size() == 8 * values.size());
  CHECK(std::memcmp(cloud.attributes.data(), values.data(), cloud.attributes.size()) == 0);
}

TEST_CASE("E57IntegersGetTheNarrowestTypeThatHoldsTheirLimits") {
  const auto type_of = [](std::int64_t minimum, std::int64_t maximum) {
    E57Scan3D scan = scan_of(some_points(2));
    scan.columns.push_back(integers("intensity", minimum, maximum, {minimum, maximum}));
    const PointCloud cloud = read_scan(scan);
    CHECK(value_of(cloud, 0, "intensity") == static_cast<double>(minimum));
    CHECK(value_of(cloud, 1, "intensity") == static_cast<double>(maximum));
    return cloud.schema.attributes.at(0).type;
  };
  CHECK(type_of(0, 255) == ScalarType::kUint8);
  CHECK(type_of(-128, 127) == ScalarType::kInt8);
  CHECK(type_of(0, 256) == ScalarType::kUint16);
  CHECK(type_of(-2048, 2047) == ScalarType::kInt16);
  CHECK(type_of(0, 65536) == ScalarType::kUint32);
  CHECK(type_of(-40000, 40000) == ScalarType::kInt32);
  CHECK(type_of(-1, std::int64_t{1} << 40) == ScalarType::kInt64);
}

TEST_CASE("E57ScaledIntegersAreExactToTheLastDigitAtUtmCoordinates") {
  const std::vector<std::int64_t> raw = {0, 1, 123456789, 4294967295, 999999};
  const double scale = 0.001, offset = 4500000.0;
  E57Scan3D scan;
  scan.columns = {scaled("cartesianX", 0, 4294967295, scale, offset, raw),
                  scaled("cartesianY", -7, 4294967295, scale, 0.0, raw),
                  scaled("cartesianZ", -4294967295, 4294967295, 1e-6, -1e-3, raw)};
  const PointCloud cloud = read_scan(scan);
  CHECK(cloud.schema.position_type == ScalarType::kFloat64);
  REQUIRE(cloud.size() == raw.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const auto value = static_cast<double>(raw[i]);
    CHECK(cloud.positions[i] == Vec3{value * scale + offset, value * scale, value * 1e-6 - 1e-3});
  }
}

TEST_CASE("E57FloatsComeOutBitForBit") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> values = {0.1f, -1e-45f, 3.4e38f, -0.0f, nan};
  E57Scan3D scan;
  scan.columns = {floats("cartesianX", values), floats("cartesianY", values),
                  floats("cartesianZ", values)};
  scan.packet_bytes = {3, 5, 4096};
  const PointCloud cloud = read_scan(scan);
  CHECK(cloud.schema.position_type == ScalarType::kFloat32);
  REQUIRE(cloud.size() == values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto expected = static_cast<double>(values[i]);
    const Vec3 p = cloud.positions[i];
    for (int axis = 0; axis < 3; ++axis)
      CHECK((std::isnan(expected)
                 ? std::isnan(p[axis])
                 : p[axis] == expected && std::signbit(p[axis]) == std::signbit(expected)));
  }
}

TEST_CASE("E57FieldsWithoutBitsHaveTheirMinimumThroughout") {
  E57Scan3D scan = scan_of(some_points(300));
  scan.columns[2] = scaled("cartesianZ", 25, 25, 0.5, 1.0, std::vector<std::int64_t>(300, 25));
  const PointCloud cloud = read_scan(scan);
  REQUIRE(cloud.size() == 300);
  for (const Vec3 p : cloud.positions) REQUIRE(p.z == 13.5);
  CHECK(cloud.positions[299].x == 299 / 3.0);
}

TEST_CASE("E57SphericalCoordinatesBecomeCartesian") {
  const double half_turn = std::acos(-1.0);
  E57Scan3D scan;
  scan.columns = {doubles("sphericalRange", {2, 2, 2, 3, 0}),
                  doubles("sphericalAzimuth", {0, half_turn / 2, -half_turn / 4, 1, 1}),
                  doubles("sphericalElevation", {0, 0, 0, half_turn / 2, 1})};
  const auto source = open_e57(make_e57({.scans = {scan}}));
  PointCloud cloud;
  REQUIRE(source->read(cloud, 100));
  CHECK(cloud.schema.position_type == ScalarType::kFloat64);
  REQUIRE(cloud.size() == 5);
  const double rounding = 1e-15;
  CHECK(distance(cloud.positions[0], {2, 0, 0}) < rounding);
  CHECK(distance(cloud.positions[1], {0, 2, 0}) < rounding);
  CHECK(distance(cloud.positions[2], {std::sqrt(2.0), -std::sqrt(2.0), 0}) < rounding);
  CHECK(distance(cloud.positions[3], {0, 0, 3}) < rounding);
  CHECK(cloud.positions[4] == Vec3{0, 0, 0});
  // Ranges are measured from the scanner.
  CHECK(source->scanner() == ScannerPlace{});
}

TEST_CASE("E57PosesMovePointsNormalsAndTheScanner") {
  E57Scan3D scan = scan_of({{1, 2, 3}, {-4, 0, 0}});
  for (const char* axis : {"nor:normalX", "nor:normalY", "nor:normalZ"})
    scan.columns.push_back(
        doubles(axis, {axis[10] == 'X' ? 1.0 : 0.0, axis[10] == 'Z' ? 1.0 : 0.0}));
  scan.xml = kQuarterTurn;
  const auto source = open_e57(make_e57({.scans = {scan}, .root_attributes = kNormals}));
  PointCloud cloud;
  REQUIRE(source->read(cloud, 100));
  REQUIRE(cloud.schema.has_normals);
  const double rounding = 1e-14;
  CHECK(distance(cloud.positions[0], {8, 21, 33}) < rounding);
  CHECK(distance(cloud.positions[1], {10, 16, 30}) < rounding);
  CHECK(distance(cloud.normals[0], {0, 1, 0}) < rounding);
  CHECK(distance(cloud.normals[1], {0, 0, 1}) < rounding);
  CHECK(source->scanner() == ScannerPlace{.vector = {10, 20, 30}});
}

TEST_CASE("E57PosesMoveNoPointThatHoldsANoDataValue") {
  const double none = -std::numeric_limits<float>::max();
  E57Scan3D scan = scan_of({{1, 2, 3}, {1, 2, none}, {none, none, none}});
  scan.xml = kQuarterTurn;
  const PointCloud cloud = read_scan(scan);
  REQUIRE(cloud.size() == 3);
  CHECK(distance(cloud.positions[0], {8, 21, 33}) < 1e-14);
  CHECK(cloud.positions[1] == Vec3{1, 2, none});
  CHECK(cloud.positions[2] == Vec3{none, none, none});
  E57Scan3D spherical;
  spherical.columns = {doubles("sphericalRange", {none}), doubles("sphericalAzimuth", {1}),
                       doubles("sphericalElevation", {1})};
  CHECK(read_scan(spherical).positions.at(0).x == none);
}

TEST_CASE("E57NormalsAreFoundWhateverTheirPrefix") {
  E57Scan3D scan = scan_of(some_points(2));
  for (const char* axis : {"n:normalX", "n:normalY", "n:normalZ"})
    scan.columns.push_back(floats(axis, {0.5f, -1.0f}));
  const PointCloud cloud =
      read_scan(scan, "xmlns:n=\"http://www.libe57.org/E57_NOR_surface_normals.txt\"");
  CHECK(cloud.schema.normal_type == ScalarType::kFloat32);
  REQUIRE(cloud.normals.size() == 2);
  CHECK(cloud.normals[1] == Vec3{-1, -1, -1});
}

TEST_CASE("E57BatchesNeverMixScansAndEachKnowsItsScanner") {
  E57Scan3D moved = scan_of(some_points(5));
  moved.xml = kQuarterTurn;
  E57Scan3D still = scan_of(some_points(3));
  E57Scan3D none = scan_of({});
  const auto source = open_e57(make_e57({.scans = {moved, none, still, moved}}));
  CHECK(source->declared_points() == 13u);
  std::vector<std::size_t> sizes;
  PointCloud batch;
  while (source->read(batch, 4)) {
    sizes.push_back(batch.size());
    CHECK(source->scanner().has_value() == (sizes.size() != 3));
  }
  CHECK(sizes == std::vector<std::size_t>{4, 1, 3, 4, 1});
  CHECK(batch.empty());
  CHECK(source->bytes_read() == source->bytes_total());
}

TEST_CASE("E57ScannerIsToldOnlyWhereItCannotBeElsewhere") {
  const auto scanner = [](const std::string& xml, bool is_gridded) {
    E57Scan3D scan = scan_of(some_points(2));
    scan.xml = xml;
    if (is_gridded) {
      scan.columns.push_back(integers("rowIndex", 0, 9, {0, 9}));
      scan.columns.push_back(integers("columnIndex", 0, 9, {3, 4}));
    }
    const auto source = open_e57(make_e57({.scans = {scan}}));
    PointCloud batch;
    REQUIRE(source->read(batch, 10));
    return source->scanner();
  };
  const std::string no_motion =
      "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">1</w>"
      "</rotation></pose>";
  CHECK(scanner("", false) == std::nullopt);
  CHECK(scanner(no_motion, false) == std::nullopt);
  CHECK(scanner("", true) == ScannerPlace{});
  CHECK(scanner(kQuarterTurn, false) == ScannerPlace{.vector = {10, 20, 30}});
  E57Scan3D both = scan_of(some_points(1));
  for (const char* name : {"sphericalRange", "sphericalAzimuth", "sphericalElevation"})
    both.columns.push_back(doubles(name, {1}));
  const auto source = open_e57(make_e57({.scans = {both}}));
  CHECK(read_all(*source).positions == some_points(1));
  CHECK(source->facts().scans.at(0).scanner == ScannerPlace{});
}

TEST_CASE("E57PointsWithoutPositionAreLeftOutAndCounted") {
  E57Scan3D first = scan_of(some_points(6));
  first.columns.push_back(integers("cartesianInvalidState", 0, 2, {0, 1, 2, 0, 0, 1}));
  first.columns.push_back(floats("intensity", {0, 1, 2, 3, 4, 5}));
  E57Scan3D second;
  second.columns = {doubles("sphericalRange", {1, 2, 3}), doubles("sphericalAzimuth", {0, 0, 0}),
                    doubles("sphericalElevation", {0, 0, 0}),
                    integers("sphericalInvalidState", 0, 2, {1, 2, 0}),
                    floats("intensity", {7, 8, 9})};
  for (const std::size_t capacity : {1, 2, 5, 100}) {
    const auto source = open_e57(make_e57({.scans = {first, second}}));
    CHECK(source->declared_points() == std::nullopt);
    PointCloud cloud, batch;
    cloud.schema = source->schema();
    while (source->read(batch, capacity)) cloud.append(batch);
    REQUIRE(cloud.size() == 4);
    CHECK(cloud.positions[1] == some_points(6)[3]);
    CHECK(cloud.positions[3] == Vec3{3, 0, 0});
    CHECK(value_of(cloud, 1, "intensity") == 3);
    CHECK(value_of(cloud, 3, "intensity") == 9);
    CHECK(source->left_out() == DroppedPoints{{"invalid position", 3}, {"no return", 2}});
  }
}

TEST_CASE("E57ColoursFillTheirType") {
  const auto read_reds = [](const E57Column& red, const std::string& limits) {
    E57Scan3D scan = scan_of(some_points(3));
    scan.xml = limits;
    for (const char* name : {"colorRed", "colorGreen", "colorBlue"}) {
      scan.columns.push_back(red);
      scan.columns.back().name = name;
    }
    return read_scan(scan);
  };
  const auto reds = [](const PointCloud& cloud) {
    return std::vector<double>{value_of(cloud, 0, "red"), value_of(cloud, 1, "green"),
                               value_of(cloud, 2, "blue")};
  };
  std::string limits = "<colorLimits type=\"Structure\">";
  for (const char* name : {"colorRed", "colorGreen", "colorBlue"})
    limits += "<" + std::string(name) + "Minimum type=\"Integer\"/><" + name +
              "Maximum type=\"Integer\">1023</" + name + "Maximum>";
  limits += "</colorLimits>";

  const PointCloud eight = read_reds(integers("", 0, 255, {0, 7, 255}), "");
  CHECK(has(eight, "red", ScalarType::kUint8));
  CHECK(reds(eight) == std::vector<double>{0, 7, 255});
  const PointCloud sixteen = read_reds(integers("", 0, 65535, {0, 700, 65535}), "");
  CHECK(has(sixteen, "blue", ScalarType::kUint16));
  CHECK(reds(sixteen) == std::vector<double>{0, 700, 65535});
  const PointCloud ten = read_reds(integers("", 0, 65535, {0, 512, 1023}), limits);
  CHECK(has(ten, "green", ScalarType::kUint16));
  CHECK(reds(ten) == std::vector<double>{0, 32800, 65535});
  const PointCloud unit = read_reds(floats("", {0.0f, 0.5f, 2.0f}), "");
  CHECK(has(unit, "red", ScalarType::kUint8));
  CHECK(reds(unit) == std::vector<double>{0, 128, 255});
}

TEST_CASE("E57ScansKeepTheAttributesThatAnyOfThemHas") {
  E57Scan3D first = scan_of(some_points(2));
  first.columns.push_back(integers("intensity", 0, 255, {1, 2}));
  first.columns.push_back(floats("nor:normalX", {1, 1}));
  first.columns.push_back(floats("nor:normalY", {0, 0}));
  first.columns.push_back(floats("nor:normalZ", {0, 0}));
  first.columns.push_back(doubles("timeStamp", {1, 2}));
  E57Scan3D second = scan_of(some_points(2));
  second.columns.push_back(doubles("unknownField", {1, 2}));
  second.columns.push_back(integers("intensity", -1000, 0, {-7, 0}));
  const PointCloud cloud = read_e57(make_e57({.scans = {first, second, scan_of({})}}));
  CHECK_FALSE(cloud.schema.has_normals);
  REQUIRE(cloud.schema.attributes ==
          std::vector<AttributeField>{{"intensity", ScalarType::kInt16},
                                      {"gps_time", ScalarType::kFloat64}});
  CHECK(value_of(cloud, 1, "intensity") == 2);
  CHECK(value_of(cloud, 2, "intensity") == -7);
  CHECK(value_of(cloud, 1, "gps_time") == 2);
  CHECK(value_of(cloud, 2, "gps_time") == 0);  // of a scan that has none
}

TEST_CASE("E57IndicesReturnsAndTimesBecomeAttributes") {
  E57Scan3D scan = scan_of(some_points(3));
  scan.columns.push_back(integers("rowIndex", 0, 1000, {0, 500, 1000}));
  scan.columns.push_back(integers("columnIndex", 0, 100, {0, 50, 100}));
  scan.columns.push_back(integers("returnIndex", 0, 3, {0, 1, 3}));
  scan.columns.push_back(integers("returnCount", 0, 4, {1, 2, 4}));
  scan.columns.push_back(doubles("timeStamp", {0, 0.25, 1}));
  scan.xml =
      "<acquisitionStart type=\"Structure\"><dateTimeValue type=\"Float\">1000000000"
      "</dateTimeValue></acquisitionStart>";
  const PointCloud cloud = read_scan(scan);
  CHECK(has(cloud, "row_index", ScalarType::kUint16));
  CHECK(has(cloud, "column_index", ScalarType::kUint8));
  CHECK(has(cloud, "return_number", ScalarType::kUint8));
  CHECK(has(cloud, "number_of_returns", ScalarType::kUint8));
  CHECK(has(cloud, "gps_time", ScalarType::kFloat64));
  CHECK(value_of(cloud, 1, "row_index") == 500);
  CHECK(value_of(cloud, 2, "column_index") == 100);
  CHECK(value_of(cloud, 0, "return_number") == 1);
  CHECK(value_of(cloud, 2, "return_number") == 4);
  CHECK(value_of(cloud, 2, "number_of_returns") == 4);
  CHECK(value_of(cloud, 1, "gps_time") == 1000000000.25);
}

TEST_CASE("E57ReturnsOfFilesConvertedFromLasCountFromOneAlready") {
  E57Scan3D scan = scan_of(some_points(2));
  scan.columns.push_back(integers("returnIndex", 0, 3, {1, 3}));
  const PointCloud cloud =
      read_scan(scan, "xmlns:las=\"http://www.astm.org/COMMIT/E57/2010-las-v1.0\"");
  CHECK(value_of(cloud, 0, "return_number") == 1);
  CHECK(value_of(cloud, 1, "return_number") == 3);
}

TEST_CASE("E57ClassesOfTheLasExtensionAreFoundWhateverItsPrefix") {
  for (const std::string prefix : {"las", "l"}) {
    E57Scan3D scan = scan_of(some_points(2));
    scan.columns.push_back(integers(prefix + ":classification", 0, 1000, {2, 6}));
    const PointCloud cloud =
        read_scan(scan, "xmlns:" + prefix + "=\"http://www.astm.org/COMMIT/E57/2010-las-v1.0\"");
    CHECK(typed_names(cloud.schema) == std::vector<std::string>{"classification uint8"});
    CHECK(value_of(cloud, 0, "classification") == 2);
    CHECK(value_of(cloud, 1, "classification") == 6);
  }
}

TEST_CASE("E57IntensityKeepsItsPrecision") {
  const auto type_of = [](const E57Column& column) {
    E57Scan3D scan = scan_of(some_points(2));
    scan.columns.push_back(column);
    return read_scan(scan).schema.attributes.at(0).type;
  };
  CHECK(type_of(floats("intensity", {0, 1})) == ScalarType::kFloat32);
  CHECK(type_of(doubles("intensity", {0, 1})) == ScalarType::kFloat64);
  CHECK(type_of(scaled("intensity", 0, 4095, 0.25, 0, {0, 1})) == ScalarType::kFloat32);
  CHECK(type_of(scaled("intensity", 1, 1 << 24, 0.1, 0, {1, 2})) == ScalarType::kFloat32);
  CHECK(type_of(scaled("intensity", 0, 1 << 24, -0.1, 0.1, {1, 2})) == ScalarType::kFloat32);
  // Floats of this size have steps of 0.0625.
  CHECK(type_of(scaled("intensity", 0, 4095, 0.001, 1e6, {0, 1})) == ScalarType::kFloat64);
  CHECK(type_of(scaled("intensity", 1LL << 40, (1LL << 40) + 7, 1.0, 0, {1LL << 40})) ==
        ScalarType::kFloat64);
}

TEST_CASE("E57FieldsOfNoInterestAreSteppedOver") {
  E57Scan3D scan = scan_of(some_points(50));
  E57Column text{"remark", "type=\"String\"", 24, std::vector<std::uint64_t>(50, 0x414102)};
  scan.columns.insert(scan.columns.begin() + 1, text);
  scan.columns.insert(scan.columns.begin(),
                      integers("x:class", 0, 5, std::vector<std::int64_t>(50, 3)));
  scan.packet_bytes = {1, 100, 7, 16, 400};
  const PointCloud cloud = read_scan(scan);
  CHECK(cloud.positions == some_points(50));
  CHECK(cloud.schema.attributes.empty());
}

TEST_CASE("E57FieldsThatNoPointHasAreTold") {
  using Strings = std::vector<std::string>;
  E57Scan3D plain = scan_of(some_points(2));
  plain.columns.push_back(integers("las:classification", 0, 5, {1, 2}));
  plain.columns.push_back(integers("isColorInvalid", 0, 1, {0, 1}));
  CHECK(open_e57(make_e57({.scans = {plain}}))->facts().lost_values.empty());
  E57Scan3D scan = plain;
  scan.columns.push_back(integers("x:pulse", 0, 5, {1, 2}));
  scan.columns.push_back(floats("x:amplitude", {1.0F, 2.0F}));
  for (const char* axis : {"nor:normalX", "nor:normalY", "nor:normalZ"})
    scan.columns.push_back(floats(axis, {0.5F, -1.0F}));
  const std::string picture = "<images2D type=\"Vector\"><vectorChild/></images2D>";
  const FileFacts one = open_e57(make_e57({.scans = {scan}, .xml = picture}))->facts();
  CHECK(one.lost_values == Strings{"fields x:amplitude, x:pulse"});
  CHECK(one.left_out == Strings{"1 picture"});
  const FileFacts two = open_e57(make_e57({.scans = {scan, plain, scan_of({})}}))->facts();
  CHECK(two.lost_values ==
        Strings{"normals, which not all scans of the file have", "fields x:amplitude, x:pulse"});
  CHECK(two.left_out.empty());
}

TEST_CASE("E57AttributesThatSomeScansLackAreTold") {
  using Strings = std::vector<std::string>;
  E57Scan3D first = scan_of(some_points(2));
  for (const char* const name : {"intensity", "colorRed", "colorGreen", "colorBlue"})
    first.columns.push_back(integers(name, 0, 255, {1, 2}));
  E57Scan3D second = scan_of(some_points(2));
  second.columns.push_back(integers("intensity", 0, 255, {1, 2}));
  const auto lost = [](const std::vector<E57Scan3D>& scans) {
    return open_e57(make_e57({.scans = scans}))->facts().lost_values;
  };
  CHECK(lost({first, first}).empty());
  CHECK(lost({first, scan_of({})}).empty());
  CHECK(lost({first, second, first}) ==
        Strings{"which points have red, green, blue: 1 of 3 scans has none, and its points get 0"});
  CHECK(lost({second, first, scan_of(some_points(1))}) ==
        Strings{
            "which points have intensity: 1 of 3 scans has none, and its points get 0",
            "which points have red, green, blue: 2 of 3 scans have none, and their points get 0"});
}

TEST_CASE("E57PacketsOfOtherKindsAreSteppedOver") {
  E57Scan3D scan = scan_of(some_points(500));
  scan.packet_bytes = {100, 33, 61};  // and the streams run apart
  scan.with_other_packets = true;
  CHECK(read_scan(scan).positions == some_points(500));
}

TEST_CASE("E57StreamsMayLieMegabytesApart") {
  E57Scan3D scan = scan_of(some_points(60000));
  scan.packet_bytes = {40000, 1000, 8000};
  const std::string file = make_e57({.scans = {scan}});
  REQUIRE(file.size() > (std::size_t{1} << 20));
  CHECK(read_e57(file).positions == some_points(60000));
}

TEST_CASE("E57PagesOfAnySizeAreRead") {
  for (const std::size_t page_bytes : {64, 1000, 1024, 65536}) {
    const std::string file =
        make_e57({.scans = {scan_of(some_points(700))}, .page_bytes = page_bytes});
    CHECK(read_e57(file).positions == some_points(700));
  }
}

TEST_CASE("E57BatchesOfAnySizeGiveTheSameCloud") {
  E57Scan3D scan = scan_of(some_points(10000));
  std::vector<std::int64_t> states;
  for (int i = 0; i < 10000; ++i) states.push_back(i % 7 == 0);
  scan.columns.push_back(integers("cartesianInvalidState", 0, 1, states));
  scan.columns.push_back(integers("colorRed", 0, 1, states));
  const std::string file = make_e57({.scans = {scan, scan}});
  const PointCloud whole = read_e57(file);
  CHECK(whole.size() == 2 * (10000 - 1429));
  for (const std::size_t capacity : {1, 2, 1000, 4096, 100000}) {
    const auto source = open_e57(file);
    PointCloud cloud, batch;
    cloud.schema = source->schema();
    while (source->read(batch, capacity)) {
      REQUIRE(batch.size() <= capacity);
      cloud.append(batch);
    }
    CHECK(same_bits(cloud, whole));
  }
}

TEST_CASE("E57CoordinateSystemIsToldAsWritten") {
  const std::string wkt = "PROJCS[\"UTM 12\"]";
  const auto source = open_e57(make_e57(
      {.scans = {scan_of(some_points(1))},
       .xml = "<coordinateMetadata type=\"String\"><![CDATA[" + wkt + "]]></coordinateMetadata>"}));
  CHECK(source->coordinate_system() == wkt);
}

TEST_CASE("E57FilesWithoutPointsAreEmptyClouds") {
  for (const E57File3D& file : {E57File3D{}, E57File3D{.scans = {scan_of({})}}}) {
    const auto source = open_e57(make_e57(file));
    CHECK(source->declared_points() == 0u);
    PointCloud batch;
    CHECK_FALSE(source->read(batch, 10));
    CHECK(batch.empty());
  }
}

TEST_CASE("E57FilesAreOpenedByTheirExtension") {
  const ScratchDirectory scratch;
  write_file(scratch / "scan.E57", make_e57({.scans = {scan_of(some_points(9))}}));
  CHECK(read_cloud(scratch / "scan.E57").positions == some_points(9));
}

TEST_CASE("AScanOutsideOfACropIsPassedOverByItsBounds") {
  // Moved by (10, 20, 30), x to y: the points lie about (10, 21, 30), and (10, 29, 30).
  const auto bounded = [](double first, const std::string& low, const std::string& high) {
    E57Scan3D scan = scan_of({{first, 0, 0}, {first + 1.0, 0, 0}});
    scan.xml = std::string(kQuarterTurn) + "<cartesianBounds><xMinimum>" + low +
               "</xMinimum><xMaximum>" + high +
               "</xMaximum><yMinimum>-1</yMinimum><yMaximum>1</yMaximum><zMinimum/>"
               "<zMaximum>0</zMaximum></cartesianBounds>";
    return scan;
  };
  const auto read = [](std::vector<E57Scan3D> scans) {
    const std::string bytes = make_e57({.scans = std::move(scans)});
    const auto source = open_e57(bytes);
    source->skip_parts([](const Box& bounds) {
      return !bounds.intersects(Box{{0, 28, 0}, {99, 31, 99}});
    });
    std::vector<double> y;
    for (PointCloud batch; source->read(batch, 10);)
      for (const Vec3& p : batch.positions) y.push_back(std::round(p.y));
    return std::pair(y, source->left_out());
  };
  using Found = std::pair<std::vector<double>, DroppedPoints>;
  CHECK(read({bounded(0, "", "1"), bounded(9, "9", "10")}) == Found{{29, 30}, {{kOutsideCrop, 2}}});
  // Bounds that are missing, no numbers, or contradicted by the points, pass over nothing.
  CHECK(read({scan_of({{5, 20, 30}}), bounded(0, "none", "1"), bounded(9, "0", "1")}) ==
        Found{{20, 20, 21, 29, 30}, {}});
}

TEST_CASE("AScanWithoutUsableBoundsIsReadWhereverItsPoseAndACropAre") {
  constexpr const char* kLargest = "1.7976931348623157e+308";
  E57Scan3D scan = scan_of({{1, 2, 3}, {4, 5, 6}});
  scan.xml = "<cartesianBounds>";
  for (const std::string axis : {"x", "y", "z"})
    scan.xml += "<" + axis + "Minimum>-" + kLargest + "</" + axis + "Minimum><" + axis +
                "Maximum>" + kLargest + "</" + axis + "Maximum>";
  scan.xml += "</cartesianBounds>";
  const std::string bytes = make_e57({.scans = {scan}});
  for (const Vec3 place : {Vec3{}, Vec3{100, 0, 0}}) {
    ScanOptions options;
    options.motion = motion_of_quaternion({0, 0, 1, 1}, place);  // x to y
    options.crop = Box{place - Vec3{9, 9, 9}, place + Vec3{9, 9, 9}};
    const auto source = open_scan_source(open_e57(bytes), options, "a.e57");
    CHECK(read_all(*source).size() == 2);
    CHECK(source->left_out().empty());
  }
}

TEST_CASE("AnE57FileTellsItsScans") {
  E57Scan3D scan = scan_of({{1, 2, 3}});
  scan.xml = std::string(
                 "<name>hall</name><sensorVendor>Acme</sensorVendor>"
                 "<sensorModel> T1 </sensorModel>") +
             kQuarterTurn;
  const std::string bytes = make_e57({.scans = {scan, scan_of({{4, 5, 6}})},
                                      .xml = "<versionMajor>1</versionMajor><versionMinor/>"
                                             "<e57LibraryVersion>lib 2</e57LibraryVersion>"});
  const FileFacts facts = open_e57(bytes)->facts();
  CHECK(facts.format == "E57");
  CHECK(facts.version == "1.0");
  CHECK(facts.software == "lib 2");
  REQUIRE(facts.scans.size() == 2);
  CHECK(facts.scans[0].name == "hall");
  CHECK(facts.scans[0].sensor == "Acme T1");
  CHECK(facts.scans[0].points == 1);
  CHECK(facts.scans[0].pose->translation == Vec3{10, 20, 30});
  CHECK(facts.scans[0].scanner == ScannerPlace{{10, 20, 30}});
  CHECK_FALSE(facts.scans[1].pose);
  CHECK_FALSE(facts.scans[1].scanner);
}

}  // namespace orbweave::test
