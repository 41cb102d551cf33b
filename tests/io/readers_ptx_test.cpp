#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "io/clouds/open_point_source.h"
#include "io/clouds/ptx_source.h"
#include "io/report/report.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Catch::Contains;
using test::attribute_names;
using test::read_cloud;
using test::reading_error;
using test::ScratchDirectory;
using test::value_of;
using test::write_file;

const std::string kAxes = "1 0 0\n0 1 0\n0 0 1\n";
const std::string kIdentity = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

/// A scan that was not moved.
std::string scan(const std::string& columns, const std::string& rows, const std::string& body) {
  return columns + "\n" + rows + "\n0 0 0\n" + kAxes + kIdentity + body;
}

std::filesystem::path sample(const std::string& name) {
  return test::data_path("samples/ascii/" + name);
}

ByteReader memory_reader(const std::string& content) {
  return ByteReader(memory_byte_source(std::as_bytes(std::span(content)), "pipe"));
}

using Names = std::vector<std::string>;

/// `p` is `expected` to the rounding of a handful of additions.
bool is_close(Vec3 p, Vec3 expected) { return norm(p - expected) <= 1e-15 * norm(expected); }

void check_refused(const std::string& content, std::initializer_list<const char*> phrases) {
  const ScratchDirectory scratch;
  write_file(scratch / "a.ptx", content);
  const std::uint64_t before = peak_memory_bytes();
  const Error error = reading_error(scratch / "a.ptx");
  INFO(error.what());
  CHECK(error.kind() == ErrorKind::kBadInput);
  CHECK_THAT(error.what(), Contains("a.ptx"));
  for (const char* phrase : phrases) CHECK_THAT(error.what(), Contains(phrase));
  CHECK(peak_memory_bytes() - before < 50'000'000);
}

}  // namespace

TEST_CASE("ARequestToStopEndsTheLookAheadAndPulsesWithoutReturn") {
  const ScratchDirectory scratch;
  std::string body;
  for (int i = 0; i < 200'000; ++i) body += i == 0 ? "1 2 3 0.5 9 9 9\n" : "0 0 0 0.5 0 0 0\n";
  write_file(scratch / "a.ptx", scan("200", "1000", body));
  StopToken stop;
  const auto source = open_point_source(scratch / "a.ptx", {.text = {}, .stop = &stop});
  CHECK(stop.checks() > 10);  // the look ahead for colours goes through all rows
  stop.request();
  PointCloud batch;
  CHECK_THROWS_AS(source->read(batch, 1000), Error);
  CHECK_THROWS_AS(open_point_source(scratch / "a.ptx", {.text = {}, .stop = &stop}), Error);
}

TEST_CASE("SamplePtxFilesHaveTheirPoints") {
  if (test::skipped_without(sample("no-color.ptx"))) return;
  const PointCloud plain = read_cloud(sample("no-color.ptx"));
  CHECK(plain.positions.size() == 15);
  CHECK(plain.positions.front() == Vec3{637012.24, 849028.31, 431.66});
  CHECK(plain.positions.back() == Vec3{635795.24, 849310.43, 426.61});
  CHECK(attribute_names(plain.schema) == Names{"intensity"});
  CHECK(attribute_value(plain, 14, 0) == static_cast<double>(0.035645f));
  const PointCloud colored = read_cloud(sample("1.2-with-color.ptx"));
  CHECK(colored.size() == 1065);
  CHECK(attribute_names(colored.schema) == Names{"intensity", "red", "green", "blue"});
  CHECK(colored.schema.attributes[1].type == ScalarType::kUint8);
  CHECK(attribute_value(colored, 1, 2) == 66.0);
}

TEST_CASE("APtxScanHasThePointsOfItsLasTwin") {
  const auto las_path = test::data_path("samples/las/1.2-with-color.las");
  if (test::skipped_without(las_path)) return;
  const PointCloud ptx = read_cloud(sample("1.2-with-color.ptx"));
  const PointCloud las = read_cloud(las_path);
  REQUIRE(ptx.size() == las.size());
  for (std::size_t i = 0; i < ptx.size(); ++i)
    REQUIRE(is_close(ptx.positions[i], las.positions[i]));
  for (const char* color : {"red", "green", "blue"})
    for (std::size_t i = 0; i < ptx.size(); ++i)
      REQUIRE(value_of(ptx, i, color) == value_of(las, i, color));
}

TEST_CASE("MatricesTurnRowVectors") {
  if (test::skipped_without(sample("complex-transform.ptx"))) return;
  // Computed apart, with numpy: [x y z 1] @ matrix.
  const std::vector<Vec3> expected = {
      {-3.0344073807900003, -3.1737810363240002, -1.823750041614},
      {-3.0344013724400001, -3.1721641004099999, -1.8237164064},
      {-3.0343657746900004, -3.1685299209859998, -1.8251146247259999},
      {-3.0343597900780002, -3.171403932184, -1.8220683500120001}};
  const auto source = open_point_source(sample("complex-transform.ptx"));
  const PointCloud cloud = read_all(*source);
  REQUIRE(cloud.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(is_close(cloud.positions[i], expected[i]));
  CHECK(source->left_out() == DroppedPoints{{"no return", 8}});
  CHECK(source->scanner() == ScannerPlace{{-3.028748, -3.819741, -1.384333}});
  CHECK(attribute_value(cloud, 0, 0) == static_cast<double>(0.494911f));
  CHECK(attribute_value(cloud, 3, 1) == 31.0);
}

TEST_CASE("MatricesMoveNoPointThatHoldsANoDataValue") {
  const std::string turned = "0.6 0.8 0 0\n-0.8 0.6 0 0\n0 0 1 0\n7 8 9 1\n";
  const std::string content =
      "1\n2\n0 0 0\n" + kAxes + turned + "1 0 0 0.5\n-3.4028e38 -3.4028e38 -3.4028e38 0.5\n";
  const auto source = open_ptx_source(memory_reader(content));
  const PointCloud cloud = read_all(*source);
  REQUIRE(cloud.size() == 2);
  CHECK(is_close(cloud.positions[0], {7.6, 8.8, 9}));
  CHECK(cloud.positions[1] == Vec3{-3.4028e38, -3.4028e38, -3.4028e38});
}

TEST_CASE("APtxFileTellsTheScansThatWereRead") {
  const std::string moved = "1\n2\n5 6 7\n" + kAxes + "0 1 0 0\n-1 0 0 0\n0 0 1 0\n5 6 7 1\n";
  const std::string content = scan("1", "2", "1 2 3 0.5\n4 5 6 0.5\n") +
                              scan("1", "1", "0 0 0 0.5\n") + moved + "1 0 0 0.5\n0 0 0 0.5\n";
  const auto source = open_ptx_source(memory_reader(content));
  PointCloud batch;
  while (source->read(batch, 1)) continue;
  const FileFacts facts = source->facts();
  CHECK(facts.format == "PTX");
  REQUIRE(facts.scans.size() == 3);
  CHECK(facts.scans[0].points == 2);
  CHECK(facts.scans[0].scanner == ScannerPlace{{0, 0, 0}});
  CHECK(facts.scans[1].points == 0);
  CHECK_FALSE(facts.scans[1].pose);
  CHECK(facts.scans[2].points == 1);
  CHECK(facts.scans[2].scanner == ScannerPlace{{5, 6, 7}});
  CHECK(facts.scans[2].pose->point({1, 0, 0}) == Vec3{5, 7, 7});
}

TEST_CASE("ABatchHoldsOneScanAndKnowsItsScanner") {
  if (test::skipped_without(sample("multiple-and-transform.ptx"))) return;
  // Two scans of one place, the first stored far from the origin and with half its heights.
  const auto source = open_point_source(sample("multiple-and-transform.ptx"));
  PointCloud first;
  PointCloud second;
  REQUIRE(source->read(first, 1000));
  CHECK(source->scanner() == ScannerPlace{{600000, 800000, 400}});
  CHECK(source->scan() == ScanNumber{0, 0});
  REQUIRE(source->read(second, 1000));
  CHECK(source->scan() == ScanNumber{0, 1});
  CHECK(source->scanner() == ScannerPlace{{0, 0, 0}});
  REQUIRE(first.size() == 4);
  REQUIRE(second.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(is_close(first.positions[i], second.positions[i]));
  CHECK(second.positions[0] == Vec3{637012.24, 849028.31, 431.66});
  CHECK_FALSE(source->read(first, 1000));
}

TEST_CASE("BatchesOfAnySizeGiveTheSamePtxCloud") {
  const std::string content = scan("2", "2", "1 2 3 0.1\n0 0 0 0.5\n4 5 6 0.2\n7 8 9 0.3\n") +
                              scan("1", "2", "0 0 0 0.5\n0 0 0 0.5\n") +
                              scan("1", "2", "nan 1 1 0\n-1 -2 -3 1\n");
  const PointCloud whole = read_all(*open_ptx_source(memory_reader(content)));
  CHECK(whole.size() == 5);
  CHECK(std::isnan(whole.positions[3].x));
  for (const std::size_t capacity : {1, 2, 3}) {
    const auto source = open_ptx_source(memory_reader(content));
    PointCloud pieces;
    pieces.schema = source->schema();
    PointCloud batch;
    while (source->read(batch, capacity)) pieces.append(batch);
    CHECK(test::same_bits(pieces, whole));
    CHECK(source->left_out() == DroppedPoints{{"no return", 3}});
  }
}

TEST_CASE("TheMatrixSaysWhereTheScannerStood") {
  const auto source = open_ptx_source(
      memory_reader("1\n1\n1 2 3\n" + kAxes +
                    "0 1 0 0\n-1 0 0 0\n0 0 1 0\n500000.123456 4649776.25 99.5 1\n1 2 3 0.5\n"));
  const PointCloud cloud = read_all(*source);
  CHECK(source->scanner() == ScannerPlace{{500000.123456, 4649776.25, 99.5}});
  CHECK(cloud.positions[0] == Vec3{500000.123456 - 2.0, 4649776.25 + 1.0, 99.5 + 3.0});
}

TEST_CASE("MillimetresSurviveAMapProjection") {
  // Steps of a tenth of a millimetre at seven digits before the point.
  std::string content =
      "1\n1000\n0 0 0\n" + kAxes + "1 0 0 0\n0 1 0 0\n0 0 1 0\n691234.5678 5334765.4321 512.3 1\n";
  for (int i = 1; i <= 1000; ++i) {
    const std::string digits = std::to_string(10000 + i).substr(1);
    content += "0." + digits + " 0." + digits + " 0 0.5\n";
  }
  const PointCloud cloud = read_all(*open_ptx_source(memory_reader(content)));
  for (int i = 1; i <= 1000; ++i) {
    const Vec3 p = cloud.positions[static_cast<std::size_t>(i - 1)];
    REQUIRE(p == Vec3{i / 1e4 + 691234.5678, i / 1e4 + 5334765.4321, 512.3});
  }
}

TEST_CASE("PulsesWithoutReturnAreLeftOutAndCounted") {
  const auto source = open_ptx_source(memory_reader(
      scan("1", "4", "0 0 0 0.5\n0 0 0 0.500000 0 0 0\n0.0 -0 0 0\n1 2 3 0.5 10 20 30\n") +
      scan("3", "1", "0 0 0 0.5\n0 0 0 0.5\n0 0 0 0.5\n")));
  const PointCloud cloud = read_all(*source);
  CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}});
  CHECK(attribute_value(cloud, 0, 3) == 30.0);
  CHECK(source->left_out() == DroppedPoints{{"no return", 6}});
  const auto nothing = open_ptx_source(memory_reader(scan("1", "2", "0 0 0 0.5\n0 0 0 0.5\n")));
  CHECK(read_all(*nothing).empty());
  CHECK(nothing->left_out() == DroppedPoints{{"no return", 2}});
}

TEST_CASE("ColorsThatNotEveryScanHasAreLeftOut") {
  const std::string with = scan("1", "2", "0 0 0 0.5 0 0 0\n1 2 3 0.25 10 20 30\n");
  const std::string without = scan("1", "1", "4 5 6 0.75\n");
  const ScratchDirectory scratch;
  write_file(scratch / "both.ptx", with + without);
  write_file(scratch / "turned.ptx", without + with);
  test::gzip_file(scratch / "both.ptx.gz", with + without);
  for (const char* name : {"both.ptx", "turned.ptx", "both.ptx.gz"}) {
    const PointCloud cloud = read_cloud(scratch / name);
    CHECK(cloud.size() == 2);
    CHECK(attribute_names(cloud.schema) == Names{"intensity"});
    CHECK(attribute_value(cloud, 0, 0) + attribute_value(cloud, 1, 0) == 1.0);
    const auto source = open_point_source(scratch / name);
    read_all(*source);
    CHECK(source->facts().lost_values == Names{"colours, which not all scans of the file have"});
  }
  write_file(scratch / "all.ptx", with + with);
  CHECK(attribute_names(read_cloud(scratch / "all.ptx").schema).size() == 4);
  CHECK(open_point_source(scratch / "all.ptx")->facts().lost_values.empty());
  CHECK(open_point_source(scratch / "both.ptx")->facts().lost_values.size() == 1);
  // A pipe cannot be looked through beforehand.
  CHECK(read_all(*open_ptx_source(memory_reader(without + with))).size() == 2);
  CHECK_THROWS_WITH(read_all(*open_ptx_source(memory_reader(with + without))),
                    Contains("line 23") && Contains("no colours") && Contains("pipe"));
}

TEST_CASE("AConvertersHeaderIsNotBelieved") {
  if (test::skipped_without(sample("ripple.ptx"))) return;
  const auto source = open_point_source(sample("ripple.ptx"));
  CHECK(read_all(*source).size() == 10201);
  CHECK_FALSE(source->scanner());
  CHECK(source->left_out().empty());  // what is not there is no row
}

TEST_CASE("TheSameSurfaceInFiveFormatsIsTheSamePoints") {
  if (test::skipped_without(sample("ripple.pts"))) return;
  const PointCloud pts = read_cloud(sample("ripple.pts"));
  const PointCloud ptx = read_cloud(sample("ripple.ptx"));
  const PointCloud text = read_cloud(sample("ripple.txt"));
  CHECK(bool(ptx.positions == pts.positions));
  CHECK(bool(text.positions == pts.positions));
  CHECK(bool(ptx.attributes == pts.attributes));  // intensity, red, green, blue
  for (const char* name : {"ripple_ascii.ply", "ripple_bin.ply"}) {
    const PointCloud ply = read_cloud(test::data_path(std::string("samples/ply/") + name));
    REQUIRE(ply.size() == pts.size());
    for (std::size_t i = 0; i < pts.size(); ++i) {
      // The text files have four decimals, the PLY files floats of up to six.
      REQUIRE(norm(ply.positions[i] - pts.positions[i]) < 1e-4);
      for (std::size_t color = 0; color < 3; ++color)
        REQUIRE(attribute_value(ply, i, color) == attribute_value(text, i, color));
    }
  }
}

TEST_CASE("CompressedAndMisnamedPtxFilesAreRead") {
  const std::string content = scan("1", "2", "1 2 3 0.5\r\n4 5 6 0.5");
  const ScratchDirectory scratch;
  test::gzip_file(scratch / "a.ptx.gz", content);
  write_file(scratch / "a.PTX", content);
  write_file(scratch / "a.txt", content);
  for (const char* name : {"a.ptx.gz", "a.PTX", "a.txt"})
    CHECK(read_cloud(scratch / name).positions == std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}});
}

TEST_CASE("DamagedPtxHeadersNameTheirLine") {
  check_refused("", {"empty"});
  check_refused("\n\n", {"no scans"});
  check_refused("x 1 2\n", {"line 1", "no PTX header", "number of columns"});
  check_refused("2\n-3\n", {"line 2", "\"-3\"", "number of rows"});
  check_refused("9223372036854775808\n1\n", {"line 1", "below 2^32"});
  check_refused("2\n2\n0 0\n", {"line 3", "\"0 0\"", "position"});
  check_refused("2\n2\n0 0 0\n1 0 0\n0 one 0\n", {"line 5", "second axis"});
  check_refused("2\n2\n0 0 0\n" + kAxes, {"ends inside the header of scan 1", "row 1"});
  check_refused("1\n1\n0 0 0\n" + kAxes + "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n1 2 3 4\n",
                {"line 10", "found 5 in row 1", "last column of 0 0 0 1"});
  check_refused("1\n1\n0 0 0\n" + kAxes + "1 0 0 0\n0 1 0 0\n0 nan 1 0\n0 0 0 1\n1 2 3 4\n",
                {"line 9", "row 3"});
  check_refused("1\n1\n0 0 0\n" + kAxes + "1 0 0 0\n0 1 0 0\n0 2 0 0\n0 0 0 1\n1 2 3 4\n",
                {"line 10", "maps space to a plane"});
}

TEST_CASE("PtxFilesThatEndEarlyAreRefused") {
  check_refused(scan("2", "3", ""), {"scan 1 has fewer rows", "2 x 3", "truncated"});
  check_refused(scan("2", "2", "1.000 2 3 0.5\n1.000 2 3 0.5\n1.000 2 3 0.5\n"),
                {"line 13", "3 rows", "2 x 2"});
  check_refused(scan("1", "2", "1.0000 2 3 0.5\n1 2"), {"line 12", "2 columns"});
  check_refused(scan("4294967295", "4294967295", "1 2 3 0.5\n"), {"fewer rows", "10 bytes"});
  const ScratchDirectory scratch;  // where the length is not known beforehand
  test::gzip_file(scratch / "a.ptx.gz", scan("4294967295", "4294967295", "1 2 3 0.5\n"));
  CHECK_THAT(reading_error(scratch / "a.ptx.gz").what(), Contains("found 1 row, "));
}

TEST_CASE("PtxRowsThatDoNotFitNameTheirLine") {
  check_refused(scan("1", "2", "1 2 3 0.5\n1 two 3 0.5\n"), {"line 12, column 2", "\"two\""});
  check_refused(scan("1", "1", "1 2 3 1e99\n"), {"line 11, column 4", "out of range"});
  check_refused(scan("1", "1", "1 2 3 0.5 1 2 256\n"), {"line 11, column 7", "0 to 255"});
  check_refused(scan("1", "1", "1 2 3 0.5 1 2\n"), {"line 11", "6 columns"});
  check_refused(scan("1", "1", "1 2 3 0.5 1 2 3 4\n"), {"line 11", "8 columns"});
  // A scan with fewer rows than it should have runs into the next one's header, one with more
  // leaves a row where a header should be.
  check_refused(scan("1", "2", "1 2 3 0.5\n") + scan("1", "1", "1 2 3 0.5\n"),
                {"line 12", "no row of scan 1", "fewer rows than its header says"});
  check_refused(scan("1", "1", "1 2 3 0.5\n1 2 3 0.5\n"),
                {"line 12", "no header of a further scan", "All rows"});
}

}  // namespace orbweave
