#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <charconv>
#include <cmath>
#include <random>

#include "io/clouds/point_source_list.h"
#include "io/clouds/text_layout.h"
#include "io/meshes/mesh_writer.h"
#include "io/text/text_number.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Catch::Contains;
using test::attribute_names;
using test::read_cloud;
using test::reading_error;
using test::ScratchDirectory;
using test::write_file;

PointCloud read_text(const std::string& name, const std::string& content,
                     const TextOptions& text = {}) {
  const ScratchDirectory scratch;
  write_file(scratch / name, content);
  return read_cloud(scratch / name, {text});
}

Error text_error(const std::string& name, const std::string& content,
                 const TextOptions& text = {}) {
  const ScratchDirectory scratch;
  write_file(scratch / name, content);
  return reading_error(scratch / name, {text});
}

using Names = std::vector<std::string>;

template <class T>
void check_like_from_chars(const std::string& text) {
  const char* const last = text.data() + text.size();
  T expected{};
  const auto [end, error] = std::from_chars(text.data(), last, expected);
  T value{};
  const char* const found = parse_number(text.data(), last, value);
  INFO(text);
  if (error != std::errc{}) {
    REQUIRE(found == nullptr);
    return;
  }
  REQUIRE(found == end);
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  REQUIRE(std::bit_cast<Bits>(value) == std::bit_cast<Bits>(expected));
}

}  // namespace

TEST_CASE("NumbersAreParsedBitForBitLikeFromChars") {
  for (const char* text : {"0",
                           "-0",
                           "5.",
                           ".5",
                           "-.5",
                           ".",
                           "-",
                           "",
                           "1e5",
                           "1e",
                           "1.5e+",
                           "1E-7",
                           "nan",
                           "-nan",
                           "inf",
                           "-infinity",
                           "1e400",
                           "8e-46",
                           "0x10",
                           "9007199254740993",
                           "16777217",
                           "16777216.5",
                           "1.00000005960464477539062",
                           "3.4028236e38",
                           "1.1754943e-38",
                           "0.000000000000000001",
                           "123456789012345678",
                           "1234567890123456789",
                           "00000000000000000001.5",
                           "1..2",
                           "1-2"}) {
    check_like_from_chars<double>(text);
    check_like_from_chars<float>(text);
  }
  std::mt19937_64 random(7);
  for (int i = 0; i < 200000; ++i) {
    std::string text = random() % 2 == 0 ? "-" : "";
    text += std::to_string(random() >> (random() % 64));
    text.insert(text.size() - random() % (text.size() - (text[0] == '-' ? 1 : 0)), ".");
    if (random() % 8 == 0) text += "e" + std::to_string(static_cast<int>(random() % 60) - 30);
    check_like_from_chars<double>(text);
    check_like_from_chars<float>(text);
  }
}

TEST_CASE("NumbersTooSmallForTheirTypeAreZero") {
  const auto is_zero = [](const std::string& text, auto value, bool is_negative) {
    const char* const last = text.data() + text.size();
    INFO(text);
    REQUIRE(parse_number(text.data(), last, value) == last);
    CHECK(value == 0);
    CHECK(std::signbit(value) == is_negative);
  };
  const std::string zeros(400, '0');
  for (const std::string& text :
       {std::string("1e-400"), std::string("2.4e-324"), "0." + zeros + "1", "0." + zeros + "1e5",
        std::string("123456789.5E-999"), std::string("1e-99999999999999999999"),
        "1" + zeros + "e-900"}) {
    is_zero(text, 1.0, false);
    is_zero("-" + text, 1.0, true);
    is_zero("+" + text, 1.0, false);
  }
  for (const char* text : {"1e-46", "7e-46", "1e-60", "1e-200", "1e-400"}) {
    is_zero(text, 1.0F, false);
    is_zero(std::string("-") + text, 1.0F, true);
  }
  for (const std::string& text : {std::string("1e400"), "1" + zeros, "0." + zeros + "1e900",
                                  std::string("1e99999999999999999999")}) {
    INFO(text);
    double value = 1.0;
    CHECK(parse_number(text.data(), text.data() + text.size(), value) == nullptr);
    std::array<std::byte, 8> bytes;
    for (const ScalarType type : {ScalarType::kFloat64, ScalarType::kFloat32, ScalarType::kUint8})
      CHECK(parse_value(text, type, bytes.data()) == ParseOutcome::kOutOfRange);
  }
  const PointCloud cloud = read_text("a.ply",
                                     "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                     "property float y\nproperty float z\nend_header\n"
                                     "1 -1e-60 3\n");
  CHECK(cloud.positions == std::vector<Vec3>{{1, 0, 3}});
  CHECK(read_text("a.xyz", "1e-400 2 3\n4 5 6\n").positions ==
        std::vector<Vec3>{{0, 2, 3}, {4, 5, 6}});
  const Error error = text_error("a.xyz", "1 2 3\n4 1e400 6\n");
  CHECK_THAT(error.what(), Contains("line 2, column 2") && Contains("out of range"));
}

TEST_CASE("FloatsHalfWayBetweenNeighboursRoundOnce") {
  // Decimals next to the midpoint of two floats: rounding to double first would decide wrongly.
  std::mt19937_64 random(11);
  for (int i = 0; i < 20000; ++i) {
    const float low =
        std::bit_cast<float>(static_cast<std::uint32_t>(0x3f000000U + (random() & 0x07ffffffU)));
    const double middle =
        0.5 * (static_cast<double>(low) + static_cast<double>(std::nextafter(low, 1e30f)));
    char text[64];
    const auto [end, error] = std::to_chars(text, text + sizeof text, middle);
    const std::string decimal(text, end);
    check_like_from_chars<float>(decimal);
    check_like_from_chars<float>(decimal.find('.') == decimal.npos ? decimal + ".0000001"
                                                                   : decimal + "0000001");
  }
}

TEST_CASE("SeparatorsAreFound") {
  const std::vector<Vec3> expected = {{1, 2, 3}, {4, 5, 6.5}};
  CHECK(read_text("a.xyz", "1 2 3\n4   5\t6.5\n").positions == expected);
  CHECK(read_text("a.txt", "1,2,3\n4, 5 ,6.5\n").positions == expected);
  CHECK(read_text("a.csv", "1;2;3\r\n4;5;6.5\r\n").positions == expected);
  CHECK(read_text("a.csv", "1\t2\t3\n4\t5\t6.5").positions == expected);
  CHECK(read_text("a.xyz", "  1 2 3  \n\n# note\n// note\n4 5 6.5\n\n").positions == expected);
  CHECK(read_text("a.csv", "1,2,3,\n4,5,6.5,\n").positions == expected);
  CHECK(read_text("a.XYZ", "+1 2e0 3.\n4 .5e1 65e-1\n").positions == expected);
  CHECK(read_text("a.xyz",
                  "\xEF\xBB\xBF"
                  "1 2 3\n4 5 6.5\n")
            .positions == expected);
}

TEST_CASE("AByteOrderMarkIsPassedOverInEveryFormatOfText") {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nend_header\n1 2 3\n";
  const std::string pcd =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\n"
      "HEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n";
  const std::string ptx =
      "1\n1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n1 2 3 0.5 9 9 9\n";
  const std::string stl =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 1 2 3\nvertex 4 2 3\nvertex 1 5 3\n"
      "endloop\nendfacet\nendsolid a\n";
  const std::string obj = "v 1 2 3\nv 4 2 3\nv 1 5 3\nf -3 -2 -1\n";
  for (const auto& [name, text] :
       std::vector<std::pair<std::string, std::string>>{{"a.ply", ply},
                                                        {"a.xyz", ply},
                                                        {"a.pcd", pcd},
                                                        {"a.txt", pcd},
                                                        {"a.ptx", ptx},
                                                        {"b.txt", ptx},
                                                        {"a.stl", stl},
                                                        {"a.obj", obj},
                                                        {"a.pts", "1\n1 2 3\n"}}) {
    CAPTURE(name);
    const PointCloud cloud = read_text(name, "\xEF\xBB\xBF" + text);
    CHECK(cloud.positions.front() == Vec3{1, 2, 3});
    CHECK(test::same_bits(cloud, read_text(name, text)));
    CHECK_THAT(text_error(name, "\xFF\xFE" + text).what(),
               Contains(name == "a.stl" ? "STL" : "the text is UTF-16; expected ASCII or UTF-8"));
  }
}

TEST_CASE("DecimalCommasAreToldAsSuch") {
  for (const char* const text :
       {"1,5;2,5;3,5\n", "1,5 2,5 3,5\n", "1,5\t2,5\t3,5\r\n", "x;y;z\n1;2;3\n1;2,5;3\n",
        "1,5, 2,5, 3,5\n4,5, 5,5, 6,5\n", "1,5, 2,5, 3,5, 128,0\r\n"}) {
    CAPTURE(text);
    CHECK_THAT(text_error("a.csv", text).what(), Contains("Write numbers with a decimal point"));
  }
  CHECK_THAT(text_error("a.csv", "one,two,three\n").what(), !Contains("decimal point"));
}

TEST_CASE("MarksBetweenThousandsAreToldAsSuch") {
  for (const char* const text :
       {"x,y,z\n\"1,234.5\",\"2,345.6\",\"3,456.7\"\n", "1,234.5 2,345.6 3,456.7\n",
        "x;y;z\n1;2;1,234,567.5\n", "1'234.5 2'345.6 3'456.7\n", "x;y;z\n1'234;2;3\n"}) {
    CAPTURE(text);
    CHECK_THAT(text_error("a.csv", text).what(), Contains("without marks between thousands"));
  }
  CHECK_THAT(text_error("a.csv", "1.234,5 2.345,6 3.456,7\n").what(), Contains("decimal point"));
}

TEST_CASE("CommasWithBlanksBehindSomeOfThemSeparateColumns") {
  for (const char* const text :
       {"1,5, 2,5, 3\n", "1, 5, 2, 5, 3, 5\n", "1,5,2,5,3,5\n", "1,5, 2,5, 3,5\n4,5,5,5,6,5\n"}) {
    CAPTURE(text);
    CHECK(read_text("a.csv", text).positions[0].y == 5.0);
  }
}

TEST_CASE("EndingsThatNameTheirColumnsAreReadAsNamed") {
  // Normals of length two, colours from 0 to 1, whole colours: no values to tell them by.
  const PointCloud normals = read_text("a.xyzn", "1 2 3 0 0 2\n4 5 6 0 2 0\n");
  CHECK(normals.normals == std::vector<Vec3>{{0, 0, 2}, {0, 2, 0}});
  CHECK(normals.schema.attributes.empty());
  const Names colors = {"red", "green", "blue"};
  const PointCloud fractions = read_text("a.xyzrgb", "1 2 3 0.5 0.25 0\n4 5 6 1 1 1\n");
  CHECK(attribute_names(fractions.schema) == colors);
  CHECK(fractions.schema.attributes[0].type == ScalarType::kUint8);
  CHECK(attribute_value(fractions, 0, 0) == 128.0);
  CHECK(attribute_value(fractions, 0, 1) == 64.0);
  CHECK(attribute_value(fractions, 1, 2) == 255.0);
  const PointCloud whole = read_text("a.xyzrgb", "1 2 3 255 128 0 9\n4 5 6 1 1 1 9\n");
  CHECK(attribute_names(whole.schema) == Names{"red", "green", "blue", "c7"});
  CHECK(whole.schema.attributes[0].type == ScalarType::kUint8);
  CHECK(read_text("a.asc", "1 2 3\n4 5 6\n").size() == 2);
}

TEST_CASE("ColorsOfXyzrgbFilesAreFractionsOnlyWhereAllMayBe") {
  const auto green_of_second = [](const std::string& lines, const TextOptions& text = {}) {
    return attribute_value(read_text("a.xyzrgb", lines, text), 1, 1);
  };
  CHECK(green_of_second("1 2 3 0.0 0.0 1.0\n4 5 6 0 0.2 1\n") == 51.0);
  CHECK(green_of_second("1 2 3 0.5 0.5 0.5\n4 5 6 0.5 0.25 2\n") == 0.25);
  TextOptions named;
  named.columns = {"x", "y", "z", "red", "green", "blue"};
  CHECK(green_of_second("1 2 3 0.5 0.5 0.5\n4 5 6 0.5 0.25 1\n", named) == 0.25);
  std::string lines;
  for (int i = 0; i < 100; ++i) lines += "1 2 3 0.5 0.5 0.5\n";
  CHECK_THAT(text_error("a.xyzrgb", lines + "1 2 3 0.5 1.5 0.5\n").what(),
             Contains("line 101, column 5") && Contains("a number from 0 to 1"));
}

TEST_CASE("NamesInQuotesMayHoldSeparators") {
  const auto names = [](const std::string& content) {
    const PointCloud cloud = read_text("a.csv", content);
    CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}});
    return attribute_names(cloud.schema);
  };
  CHECK(names("x,y,z,\"light, raw\",\"t\"\n1,2,3,4,5\n") == Names{"light, raw", "t"});
  CHECK(names("\"a, b\" ,x,y,z\n4,1,2,3\n") == Names{"a, b"});
  CHECK(names("x\ty\tz\t\"a\tb\"\t \"c d\"\n1\t2\t3\t4\t5\n") == Names{"a\tb", "c d"});
  CHECK(names("x y z \"a b\" c\n1 2 3 4 5\n") == Names{"a b", "c"});
  CHECK(names("x,y,z,\"a \"\", b\"\n1,2,3,4\n") == Names{"a \"\", b"});
  CHECK(names("x,y,z,\"a\"b,c\n1,2,3,4,5\n") == Names{"\"a\"b", "c"});
  CHECK(names("x,y,z,\"a,t\n1,2,3,4,5\n") == Names{"\"a", "t"});
  CHECK(names("x,y,z,\"\",t\n\"1\",\"2\" ,3,4,5\n") == Names{"c4", "t"});
}

TEST_CASE("HeaderLinesNameTheColumns") {
  const PointCloud cloud = read_text(
      "a.csv", "\"Z\",NX,ny,nz,X,Y,R,G,B,Intensity,time stamp\n3,0,0,1,1,2,10,20,30,0.5,99\n");
  CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}});
  CHECK(cloud.normals == std::vector<Vec3>{{0, 0, 1}});
  CHECK(attribute_names(cloud.schema) == Names{"red", "green", "blue", "intensity", "time stamp"});
  CHECK(cloud.schema.attributes[0].type == ScalarType::kUint8);
  CHECK(cloud.schema.attributes[3].type == ScalarType::kFloat64);
  CHECK(attribute_value(cloud, 0, 4) == 99.0);
  const PointCloud unit_colors = read_text("a.txt", "x y z r g b\n1 2 3 0.5 0 1\n");
  CHECK(unit_colors.schema.attributes[0].type == ScalarType::kFloat64);
  const PointCloud comment = read_text("a.xyz", "//X Y Z temperature\n1 2 3 4\n");
  CHECK(attribute_names(comment.schema) == Names{"temperature"});
}

TEST_CASE("CoordinatesMayBeNamedAsSurveyorsAndParaViewNameThem") {
  const auto names = [](const std::string& content) {
    const PointCloud cloud = read_text("a.csv", content);
    CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}});
    return attribute_names(cloud.schema);
  };
  CHECK(names("Point,Northing,Easting,Elevation\n7,2,1,3\n") == Names{"Point"});
  CHECK(names("# Easting[m];Northing[m];Height[m];i\n1;2;3;0.5\n") == Names{"i"});
  CHECK(names("X,Y,Elevation\n1,2,3\n").empty());
  CHECK(names("Easting,X,Y,Z\n9,1,2,3\n") == Names{"Easting"});
  CHECK(names("x,y,elevation,height\n1,2,3,4\n") == Names{"height"});
  const std::string row = "10,20,30,0,0,1,0.5,1,2,3\n";
  CHECK(names("\"RGB:0\",\"RGB:1\",\"RGB:2\",\"Normals:0\",\"Normals:1\",\"Normals:2\",\"t\","
              "\"Points:0\",\"Points:1\",\"Points:2\"\n" +
              row) == Names{"red", "green", "blue", "t"});
  CHECK_THAT(text_error("a.csv", "Longitude,Latitude,Height\n1,2,3\n").what(),
             Contains("x, y and z"));
  CHECK_THAT(text_error("a.csv", "Easting,Northing,Depth\n1,2,3\n").what(), Contains("Easting"));
}

TEST_CASE("NamesInACommentMayHaveASeparatorOfTheirOwn") {
  const auto names = [](const std::string& content) {
    const PointCloud cloud = read_text("a.txt", content);
    CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}});
    return attribute_names(cloud.schema);
  };
  // NumPy's savetxt writes its header so, whatever its delimiter.
  CHECK(names("# x, y, z, intensity\n1 2 3 0.5\n") == Names{"intensity"});
  CHECK(names("# intensity,x,y,z\n0.5 1 2 3\n") == Names{"intensity"});
  CHECK(names("//X Y Z R G B\n1,2,3,10,20,30\n") == Names{"red", "green", "blue"});
  CHECK(names("# x; y; z; gps time\n1 2 3 0.5\n") == Names{"gps time"});
  CHECK(names("% intensity x y z\n0.5 1 2 3\n") == Names{"intensity"});
  CHECK(names("% written by MATLAB\n1 2 3\n%\n").empty());
  CHECK(names("# x, y and z in metres\n1 2 3 0.5\n") == Names{"c4"});
}

TEST_CASE("ColumnsOfAHeaderMayNameTheirUnits") {
  const PointCloud riscan = read_text("a.csv", "X[m],Y[m],Z[m],Amplitude[dB]\n1,2,3,4.5\n");
  CHECK(riscan.positions == std::vector<Vec3>{{1, 2, 3}});
  CHECK(attribute_names(riscan.schema) == Names{"Amplitude[dB]"});
  CHECK(read_text("a.csv", "X (m);Y (m);Z (m)\n1;2;3\n").positions == riscan.positions);
  CHECK_THAT(text_error("a.csv", "X[m],X[ft],Y,Z\n1,2,3,4\n").what(), Contains("one name"));
}

TEST_CASE("NamedColorsHaveTheirBitsInAnyNotation") {
  const auto type_of_red = [](const std::string& lines) {
    return read_text("a.csv", "X,Y,Z,Red,Green,Blue\n" + lines).schema.attributes.at(0).type;
  };
  CHECK(type_of_red("1,2,3,128,0,1\n") == ScalarType::kUint8);
  CHECK(type_of_red("1,2,3,128.000,0.000,1.000\n") == ScalarType::kUint8);
  CHECK(type_of_red("1,2,3,1.28e+02,0.0e+00,1.0e+00\n") == ScalarType::kUint8);
  CHECK(type_of_red("1,2,3,0,0,1\n") == ScalarType::kUint8);
  CHECK(type_of_red("1,2,3,65280,0,1\n") == ScalarType::kUint16);
  CHECK(type_of_red("1,2,3,65280.000,0.000,1.000\n4,5,6,1,2,3\n") == ScalarType::kUint16);
  CHECK(type_of_red("1,2,3,1.0,0.0,1.0\n") == ScalarType::kFloat64);
  CHECK(type_of_red("1,2,3,128.5,0,1\n") == ScalarType::kFloat64);
  CHECK(type_of_red("1,2,3,65536,0,1\n") == ScalarType::kFloat64);
  CHECK(type_of_red("1,2,3,-1,0,1\n") == ScalarType::kFloat64);
  const PointCloud cloud = read_text("a.csv", "x,y,z,r,g,b\n1,2,3,128.000,2.0,1e1\n");
  CHECK(attribute_value(cloud, 0, 0) == 128.0);
  CHECK(attribute_value(cloud, 0, 2) == 10.0);
}

TEST_CASE("ALineOfVeryManyNumbersIsNoPoint") {
  std::string line;
  for (int column = 0; column < 4096; ++column) line += "1 ";
  CHECK(read_text("a.xyz", line + "\n").size() == 1);
  CHECK_THROWS_WITH(read_text("a.xyz", line + "1\n"),
                    Contains("too many columns") && Contains("4097 columns"));
}

TEST_CASE("ColumnsWithoutNamesAreToldByTheirValues") {
  const PointCloud normals = read_text("a.xyz", "1 2 3 0 0 1\n4 5 6 0.6 -0.8 0\n");
  CHECK(normals.schema.has_normals);
  CHECK(normals.normals[1] == Vec3{0.6, -0.8, 0});
  const PointCloud colors = read_text("a.xyz", "1 2 3 0 0 1\n4 5 6 255 128 0\n");
  CHECK_FALSE(colors.schema.has_normals);
  CHECK(attribute_names(colors.schema) == Names{"red", "green", "blue"});
  CHECK(attribute_value(colors, 1, 0) == 255.0);
  const PointCloud other = read_text("a.xyz", "1 2 3 0 0 1\n4 5 6 256 128 0\n");
  CHECK(attribute_names(other.schema) == Names{"c4", "c5", "c6"});
  CHECK(attribute_names(read_text("a.xyz", "1 2 3 4\n").schema) == Names{"c4"});
  CHECK(attribute_names(read_text("a.pts", "1\n1 2 3 -7\n").schema) == Names{"intensity"});
  CHECK(attribute_names(read_text("a.pts", "1 2 3 10 52 70 64\n").schema) ==
        Names{"intensity", "red", "green", "blue"});
}

TEST_CASE("ColorsWithoutNamesMayBeWrittenWithDecimals") {
  // NumPy's savetxt writes all columns of an array alike.
  const PointCloud cloud =
      read_text("a.txt",
                "1.000e+00 2.000e+00 3.000e+00 1.280e+02 0.000e+00 9.000e+00\n"
                "4.500e+00 5.000e+00 6.000e+00 2.550e+02 7.000e+00 0.000e+00\n");
  CHECK(attribute_names(cloud.schema) == Names{"red", "green", "blue"});
  CHECK(cloud.schema.attributes[0].type == ScalarType::kUint8);
  CHECK(attribute_value(cloud, 1, 0) == 255.0);
  const auto names = [](const std::string& content) {
    return attribute_names(read_text("a.txt", content).schema);
  };
  CHECK(names("1 2 3 128.000 2.000 9.000\n") == Names{"red", "green", "blue"});
  CHECK(names("1 2 3 0.25 128.0 2.0 9.0\n") == Names{"c4", "red", "green", "blue"});
  const Names places = {"c4", "c5", "c6"};
  CHECK(names("1 2 3 128.0 2.0 1.0\n4 5 6 7.0 3.0 1.0\n") == places);
  CHECK(names("1 2 3 128.0 2.0 9.5\n") == places);
  CHECK(names("1 2 3 256.0 2.0 9.0\n") == places);
}

TEST_CASE("ColumnsThatMayAsWellBeColorsAreTold") {
  const auto told = [](const std::string& name, const std::string& content,
                       const TextOptions& text = {}) {
    const ScratchDirectory scratch;
    write_file(scratch / name, content);
    return not_read(open_point_source(scratch / name, {text})->facts());
  };
  const auto notes = told("a.xyz", "1 2 3 0.5 90 10 20 30\n4 5 6 0.5 91 11 21 31\n");
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Contains("columns 5 to 8") && Contains("5 to 7 are taken for red, green"));
  CHECK(told("a.xyz", "1 2 3 90.0 10 20 30\n").empty());
  CHECK(told("a.xyz", "1 2 3 10 20 30 90.0 1\n").empty());
  CHECK(told("a.xyz", "1 2 3 10 20\n").empty());
  CHECK(told("a.pts", "1 2 3 90 10 20 30\n").empty());
  CHECK(told("a.txt", "x y z i r g b\n1 2 3 90 10 20 30\n").empty());
  TextOptions text;
  text.columns = {"x", "y", "z", "i", "r", "g", "b"};
  CHECK(told("a.xyz", "1 2 3 90 10 20 30\n", text).empty());
}

TEST_CASE("RowsAndColumnsOfAGridInPlaceOfCoordinatesAreTold") {
  const auto told = [](const std::string& content, const TextOptions& text = {}) {
    const ScratchDirectory scratch;
    write_file(scratch / "a.xyz", content);
    return not_read(open_point_source(scratch / "a.xyz", {text})->facts());
  };
  const std::string faro = "0 17 1.5 2.25 -0.125 10 20 30\n0 18 1.5 2.5 -0.125 10 20 30\n";
  const auto notes = told(faro);
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Contains("columns 1 to 5") && Contains("-,-,x,y,z"));
  TextOptions text;
  text.columns = {"-", "-", "x", "y", "z", "red:uint8", "green:uint8", "blue:uint8"};
  CHECK(told(faro, text).empty());
  CHECK(told("500000 4000000 1.5 2.25 3.5\n").empty());
  CHECK(told("0 17 1.5 2.25 3\n").empty());
  CHECK(told("0 17 1.5 2.25 3.5\n0.5 18 1.5 2.25 3.5\n").empty());
  CHECK(told("# x y z a b\n0 17 1.5 2.25 3.5\n").empty());
}

TEST_CASE("ColumnsMayBeGiven") {
  TextOptions text;
  text.columns = {"y", "-", "x", "z:float32", "class:uint8"};
  const PointCloud cloud = read_text("a.txt", "2 word 1 0.1 7\n", text);
  CHECK(cloud.positions == std::vector<Vec3>{{1, 2, static_cast<double>(0.1f)}});
  CHECK(cloud.schema.attributes == std::vector<AttributeField>{{"class", ScalarType::kUint8}});
  CHECK(text_error("a.txt", "2 word 1 0.1 300\n", text).kind() == ErrorKind::kBadInput);
  CHECK(read_text("a.txt", "a b c d e\n2 word 1 3 7\n", text).size() == 1);
  text.columns = {"x", " y", " z", " t:uint8 "};
  CHECK(read_text("a.txt", "1 2 3 4\n", text).schema.attributes ==
        std::vector<AttributeField>{{"t", ScalarType::kUint8}});
  text.columns = {"x", "y"};
  CHECK(text_error("a.txt", "1 2\n", text).kind() == ErrorKind::kUsage);
  CHECK_THAT(text_error("a.txt", "1 2\n", text).what(), Contains("found \"x, y\""));
  text.columns = {"x", "y", "z", "x"};
  CHECK(text_error("a.txt", "1 2 3 4\n", text).kind() == ErrorKind::kUsage);
  text.columns = {"x", "y", "z", "t:int7"};
  CHECK(text_error("a.txt", "1 2 3 4\n", text).kind() == ErrorKind::kUsage);
  text.columns = {};
  text.separator = ';';
  CHECK(read_text("a.txt", "1;2;3\n", text).size() == 1);
  CHECK(text_error("a.txt", "1 2 3\n", text).kind() == ErrorKind::kBadInput);
}

TEST_CASE("ALetterInLineSevenIsNamedByLineAndColumn") {
  for (const char* separator : {" ", ",", ";", "\t"}) {
    std::string content;
    for (int line = 1; line <= 9; ++line)
      content += "1" + std::string(separator) + (line == 7 ? "2O5" : "2.5") + separator + "3\n";
    const Error error = text_error("a.txt", content);
    INFO(error.what());
    CHECK(error.kind() == ErrorKind::kBadInput);
    CHECK(error.parts().place == "line 7, column 2");
    CHECK(error.parts().found == "\"2O5\"");
    CHECK(error.parts().expected == "a number");
    CHECK_THAT(error.what(), Contains("a.txt"));
  }
}

TEST_CASE("AnEmptyFieldIsOneWhereverItStands") {
  for (const char* separator : {",", ";", "\t"}) {
    const std::string s = separator;
    const std::string header = "x" + s + "y" + s + "z" + s + "rain fall" + s + "snow fall\n";
    for (const std::string& row :
         {"4" + s + s + "6" + s + "7" + s + "8", "4" + s + "5" + s + s + "7" + s + "8",
          "4" + s + "5" + s + "6" + s + s + "8", "4" + s + "5" + s + "6" + s + "7" + s}) {
      const Error error =
          text_error("a.txt", header + "1" + s + "2" + s + "3" + s + "4" + s + "5\n" + row + "\n");
      INFO(row);
      CHECK_THAT(error.parts().place, Contains("line 3, column "));
      CHECK(error.parts().found == "\"\"");
      CHECK_THAT(error.parts().advice, Contains("nan where a value is missing"));
    }
  }
  CHECK_THAT(text_error("a.csv", "x,y,z,kind\n1,2,3,tree\n").parts().advice,
             Contains("- in place of kind in input.columns"));
  // A column that is left out may be empty, the last one as well; a line without it is none.
  TextOptions text;
  text.columns = {"x", "y", "z", "-", "-"};
  CHECK(read_text("a.csv", "1,2,3,4,5\n1,2,4,,\n1,2,5,,6\n", text).size() == 3);
  CHECK_THAT(text_error("a.csv", "1,2,3,4,5\n1,2,4,\n", text).what(),
             Contains("line 2: the line has another number of columns"));
  // Some programs end their lines so.
  CHECK(read_text("a.csv", "x,y,z,i\n1,2,3,4,\n1,2,4,5,\n").size() == 2);
}

TEST_CASE("LinesBeyondTheSampleAreCheckedToo") {
  std::string content;
  for (int line = 1; line <= 5000; ++line) content += "1 2 3 10 20 30\n";
  CHECK(text_error("a.txt", content + "1 2 3 10 20\n").parts().place == "line 5001");
  CHECK(text_error("a.txt", content + "1 2 3 10 20 30 40\n").parts().found == "7 columns");
  std::string named;
  for (int line = 1; line <= 5000; ++line) named += "1 2 3 10\n";
  for (const std::string name : {"r", "blue", "a", "alpha"})
    CHECK(read_text("a.txt", "x y z " + name + "\n" + named + "1 2 3 300.5\n").size() == 5001);
  const Error color = text_error("a.txt", content + "1 2 3 10 20 300\n");
  CHECK(color.parts().place == "line 5001, column 6");
  CHECK(color.parts().expected == "an integer from 0 to 255");
  CHECK(text_error("a.txt", content + "1 2 3 , 20 30\n").parts().found == "\",\"");
  CHECK(text_error("a.csv", "1,2,3\n1,,3\n").parts().place == "line 2, column 2");
}

TEST_CASE("TextThatIsNoCloudIsRefused") {
  CHECK_THAT(text_error("a.xyz", "1 2\n3 4\n").what(), Contains("line 1") && Contains("2 columns"));
  CHECK_THAT(text_error("a.xyz", "Dear reader,\n").what(), Contains("line 1, column 1"));
  CHECK_THAT(text_error("a.xyz", "# nothing\n\n").what(), Contains("no points"));
  CHECK_THAT(text_error("a.csv", "x,y,z,y\n1,2,3,4\n").what(), Contains("one name"));
  CHECK_THAT(text_error("a.xyz", std::string(3'000'000, '7')).what(), Contains("more than"));
}

TEST_CASE("CountsOfPtsFilesAreAFloor") {
  CHECK(read_text("a.pts", "2\n1 2 3\n4 5 6\n").size() == 2);
  CHECK(read_text("a.pts", "1\n1 2 3\n4 5 6\n").size() == 2);
  CHECK(read_text("a.pts", "1 2 3\n4 5 6\n").size() == 2);
  const Error error = text_error("a.pts", "3\n1 2 3\n4 5 6\n");
  CHECK(error.kind() == ErrorKind::kBadInput);
  CHECK(error.parts().found == "2 points");
  CHECK(error.parts().expected == "3");
}

TEST_CASE("ACountBeforeThePointsIsNoPointInAnyTextFile") {
  CHECK(read_text("a.xyz", "2\n1 2 3\n4 5 6\n").size() == 2);
  const PointCloud named = read_text("a.txt", "//X Y Z Intensity\n2\n1 2 3 0.5\n4 5 6 0.5\n");
  CHECK(attribute_names(named.schema) == std::vector<std::string>{"intensity"});
  CHECK(named.size() == 2);
  CHECK(text_error("a.csv", "3\n1,2,3\n4,5,6\n").parts().found == "2 points");
  // Further counts are those of .pts files.
  CHECK_THAT(text_error("a.xyz", "1\n1 2 3\n1\n4 5 6\n").what(), Contains("line 3"));
  CHECK_THAT(text_error("a.xyz", "1\n2\n3\n").what(), Contains("line 2") && Contains("1 column"));
}

TEST_CASE("SampleTextFilesHaveTheirPoints") {
  const auto sample = [](const std::string& name) {
    return test::data_path("samples/ascii/" + name);
  };
  if (test::skipped_without(sample("ripple.pts"))) return;
  const PointCloud ripple = read_cloud(sample("ripple.pts"));
  CHECK(ripple.size() == 10201);
  CHECK(ripple.bounds().min.x == -5.0);
  CHECK(ripple.bounds().max.y == 5.0);
  CHECK(attribute_names(ripple.schema) == Names{"intensity", "red", "green", "blue"});
  CHECK(read_cloud(sample("autzen.pts")).size() == 10);
  CHECK(read_cloud(sample("test.pts")).size() == 19);
  CHECK(read_cloud(sample("site_56_8.pts")).size() == 8);
  CHECK(read_cloud(sample("bunny_8.pts")).size() == 9);  // one more than its first line says
  const PointCloud text = read_cloud(sample("ripple.txt"));
  CHECK(text.size() == 10201);
  CHECK(text.schema.has_normals);
  CHECK(attribute_names(text.schema) == Names{"red", "green", "blue"});
}

TEST_CASE("SeveralFilesAreOneStream") {
  const ScratchDirectory scratch;
  write_file(scratch / "a.csv", "x,y,z,red,green,blue,time\n1,2,3,4,5,6,7\n");
  write_file(scratch / "b.csv", "time,blue,x,y,z,extra,red,green\n70,60,10,20,30,1,40,50\n");
  write_file(scratch / "c.ply",
             "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
             "property float z\nproperty double time\nproperty int red\nend_header\n8 8 8 9 1\n");
  std::vector<std::string> notes;
  const auto two = open_point_sources({scratch / "a.csv", scratch / "b.csv"}, {}, &notes);
  const PointCloud cloud = read_all(*two);
  CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}, {10, 20, 30}});
  // In the order of the file that has most of them.
  CHECK(attribute_names(cloud.schema) == Names{"time", "blue", "extra", "red", "green"});
  CHECK(attribute_value(cloud, 0, 0) == 7.0);
  CHECK(attribute_value(cloud, 0, 2) == 0.0);  // a.csv has no extra
  CHECK(attribute_value(cloud, 1, 1) == 60.0);
  CHECK(attribute_value(cloud, 1, 3) == 40.0);
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Contains("extra") && Contains("a.csv, which lacks it"));
  CHECK(two->bytes_read() == two->bytes_total());
  const auto three =
      open_point_sources({scratch / "a.csv", scratch / "b.csv", scratch / "c.ply"}, {}, &notes);
  CHECK(attribute_names(read_all(*three).schema) == Names{"time", "blue", "extra", "red", "green"});
  CHECK(three->schema().attributes[0].type == ScalarType::kFloat64);
  CHECK(three->schema().position_type == ScalarType::kFloat64);
}

TEST_CASE("FilesWithAndWithoutNormalsDoNotMix") {
  const ScratchDirectory scratch;
  write_file(scratch / "a.xyz", "1 2 3 0 0 1\n");
  write_file(scratch / "b.xyz", "1 2 3\n");
  for (const auto& [first, second] : {std::pair("a.xyz", "b.xyz"), std::pair("b.xyz", "a.xyz")}) {
    CHECK_THROWS_WITH(open_point_sources({scratch / first, scratch / second}),
                      Contains("b.xyz: ") && Contains("normals as in") && Contains("a.xyz"));
  }
  CHECK_THROWS_AS(open_point_sources({}), Error);
}

}  // namespace orbweave
