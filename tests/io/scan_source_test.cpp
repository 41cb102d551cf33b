// What a job makes of a scan: filters, poses and the direction to the scanner.
#include "io/clouds/scan_source.h"

#include <catch2/catch.hpp>
#include <cstring>

#include "io/clouds/pcd_source.h"
#include "io/points/point_views.h"
#include "io/stop_token.h"
#include "tests/io/reading.h"

namespace orbweave::test {
namespace {

/// Seven points at x = 0, 1, ... with classes and returns, as `header` names and types them.
std::string classified_pcd(const std::string& fields, const std::string& types,
                           const std::string& sizes) {
  return "FIELDS x y z " + fields + "\nSIZE 4 4 4 " + sizes + "\nTYPE F F F " + types +
         "\nPOINTS 7\nDATA ascii\n"
         "0 0 0 2 1 1\n1 0 0 6 1 2\n2 0 0 2 2 2\n3 0 0 0 1 3\n4 0 0 255 2 3\n5 0 0 2 3 3\n"
         "6 0 0 7 0 0\n";
}

std::unique_ptr<PointSource> open_pcd(const std::string& content) {
  return open_pcd_source(ByteReader(memory_byte_source(std::as_bytes(std::span(content)), "a")));
}

std::unique_ptr<PointSource> open_scan(const std::string& content, const ScanOptions& options) {
  return open_scan_source(open_pcd(content), options, "a.pcd");
}

std::vector<int> kept_of(PointSource& source, std::size_t capacity = 2) {
  std::vector<int> kept;
  PointCloud batch;
  while (source.read(batch, capacity))
    for (const Vec3& p : batch.positions) kept.push_back(static_cast<int>(p.x));
  return kept;
}

const std::string kLasNames = "classification return_number number_of_returns";

/// One point at (1, 2, 3), seen from `viewpoint` by the file's word; empty: it says nothing.
std::string pcd_seen_from(const std::string& viewpoint) {
  return "FIELDS x y z\nWIDTH 1\n" +
         (viewpoint.empty() ? "" : "VIEWPOINT " + viewpoint + " 1 0 0 0\n") + "DATA ascii\n1 2 3\n";
}

ViewCode view_of(const PointCloud& cloud) {
  const auto offset = view_offset(cloud.schema);
  REQUIRE(offset);
  ViewCode code;
  std::memcpy(&code, cloud.attribute_row(0).data() + *offset, sizeof code);
  return code;
}

}  // namespace

TEST_CASE("ClassesThatAreNotWantedAreLeftOutAndCounted") {
  const std::string content = classified_pcd(kLasNames, "U U U", "1 1 1");
  const auto source = open_scan(content, {.classes = {2, 255}});
  CHECK(kept_of(*source) == std::vector<int>{0, 2, 4, 5});
  CHECK(source->left_out() == DroppedPoints{{"class 0 (never classified) not selected", 1},
                                            {"class 6 (building) not selected", 1},
                                            {"class 7 (low point) not selected", 1}});
}

TEST_CASE("ReturnsThatAreNotWantedAreLeftOutAndCounted") {
  const std::string content = classified_pcd(kLasNames, "U U U", "1 1 1");
  const auto kept = [&](ReturnFilter returns, const DroppedPoints& dropped) {
    const auto source = open_scan(content, {.returns = returns});
    std::vector<int> points = kept_of(*source, 3);
    CHECK(source->left_out() == dropped);
    return points;
  };
  CHECK(kept(ReturnFilter::kAll, {}).size() == 7);
  CHECK(kept(ReturnFilter::kFirst, {{"not a first return", 3}}) == std::vector<int>{0, 1, 3, 6});
  CHECK(kept(ReturnFilter::kLast, {{"not a last return", 3}}) == std::vector<int>{0, 2, 5, 6});
  CHECK(kept(ReturnFilter::kOnly, {{"not an only return", 5}}) == std::vector<int>{0, 6});
}

TEST_CASE("AStopIsSeenWhereNoPointIsWanted") {
  const std::string content = classified_pcd(kLasNames, "U U U", "1 1 1");
  StopToken stop;
  const ScanOptions options = {.crop = Box{{50, 50, 50}, {60, 60, 60}}, .stop = &stop};
  CHECK(kept_of(*open_scan(content, options)).empty());
  CHECK(stop.checks() >= 4);  // batches of two points
  stop.request();
  CHECK_THROWS_WITH(kept_of(*open_scan(content, options)), kInterruptedText);
}

TEST_CASE("FiltersGoByAttributesOfAnyTypeAndSpelling") {
  const ScanOptions options = {.classes = {2, 255}, .returns = ReturnFilter::kLast};
  for (const auto& [types, sizes] :
       {std::pair("U U U", "1 1 1"), std::pair("F I U", "4 2 8"), std::pair("F F F", "8 8 8")}) {
    CAPTURE(types);
    for (const std::string& names : {kLasNames, std::string("Classification ReturnNumber "
                                                            "NumberOfReturns")}) {
      const std::string content = classified_pcd(names, types, sizes);
      CHECK(kept_of(*open_scan(content, options)) == std::vector<int>{0, 2, 5});
    }
  }
  // What is no class at all is none that is wanted.
  const std::string odd =
      "FIELDS x y z classification\nWIDTH 4\nDATA ascii\n0 0 0 nan\n1 0 0 -1\n2 0 0 1e9\n3 0 0 2\n";
  const auto source = open_scan(odd, {.classes = {0, 2}});
  CHECK(kept_of(*source) == std::vector<int>{3});
  CHECK(source->left_out() == DroppedPoints{{"no class from 0 to 255", 3}});
}

TEST_CASE("APoseMovesNoPointThatHoldsANoDataValue") {
  const RigidMotion motion = motion_of_quaternion({0.1, 0.2, 0.3, 1}, {1e6, 0, 0});
  const double none = -3.4028e38;
  const std::string content =
      "FIELDS x y z\nWIDTH 3\nDATA ascii\n1 2 3\n1 -3.4028e38 3\n"
      "-3.4028e38 -3.4028e38 -3.4028e38\n";
  const auto source = open_scan(content, {.motion = motion});
  PointCloud batch;
  REQUIRE(source->read(batch, 10));
  REQUIRE(batch.size() == 3);
  CHECK(batch.positions[0] == motion.point({1, 2, 3}));
  for (const int axis : {0, 2}) CHECK(batch.positions[1][axis] == axis + 1.0);
  CHECK(batch.positions[1].y == Approx(none).epsilon(1e-6));
  for (const int axis : {0, 1, 2}) CHECK(batch.positions[2][axis] == Approx(none).epsilon(1e-6));
}

TEST_CASE("AFilterWithoutItsAttributeNamesFileAndKey") {
  using Catch::Contains;
  const std::string plain = pcd_seen_from("");
  CHECK_THROWS_WITH(open_scan(plain, {.classes = {2}}), Contains("a.pcd") &&
                                                            Contains("no classification") &&
                                                            Contains("input.las_classes"));
  CHECK_THROWS_WITH(open_scan(plain, {.returns = ReturnFilter::kLast}),
                    Contains("no return_number") && Contains("input.returns"));
}

TEST_CASE("AttributesMayGoOnceTheyHaveFiltered") {
  const std::string content = classified_pcd(kLasNames, "U U U", "1 1 1");
  const auto source = open_scan(content, {.without_attributes = true, .classes = {6}});
  PointCloud batch;
  REQUIRE(source->read(batch, 10));
  CHECK(batch.positions == std::vector<Vec3>{{1, 0, 0}});
  CHECK(batch.schema.attributes.empty());
  CHECK(batch.attributes.empty());
}

TEST_CASE("TheJobsScannerWinsOverTheFilesAndThatOverTheUsualOne") {
  const ScannerPlace told{{7, 7, 7}}, usual{{0, 0, 1}, true};
  const auto scanner_of = [](const std::string& content, const ScanOptions& options) {
    const auto source = open_scan(content, options);
    PointCloud batch;
    REQUIRE(source->read(batch, 10));
    return source->scanner();
  };
  const std::string silent = pcd_seen_from("");
  const std::string telling = pcd_seen_from("1 2 10");
  CHECK_FALSE(scanner_of(silent, {}));
  CHECK(scanner_of(silent, {.usual_scanner = usual}) == usual);
  CHECK(scanner_of(telling, {.usual_scanner = usual}) == ScannerPlace{{1, 2, 10}});
  CHECK(scanner_of(telling, {.scanner = told, .usual_scanner = usual}) == told);
}

TEST_CASE("ThePoseMovesPointsAndScannerAndTheViewPointsFromOneToTheOther") {
  // A quarter turn about z, x to y, and a shift.
  const RigidMotion motion = motion_of_quaternion({0, 0, 1, 1}, {1e6, 0, 0});
  const auto source = open_scan(pcd_seen_from("1 5 3"), {.motion = motion, .with_view = true});
  CHECK(source->schema().position_type == ScalarType::kFloat64);
  PointCloud batch;
  REQUIRE(source->read(batch, 10));
  REQUIRE(batch.size() == 1);
  CHECK(norm(batch.positions[0] - Vec3{1e6 - 2, 1, 3}) < 1e-9);
  CHECK(norm(source->scanner()->vector - Vec3{1e6 - 5, 1, 3}) < 1e-9);
  CHECK(norm(decode_view(view_of(batch)) - Vec3{-1, 0, 0}) < 1e-4);
  const auto blind = open_scan(pcd_seen_from(""), {.with_view = true});
  REQUIRE(blind->read(batch, 10));
  CHECK_FALSE(view_of(batch).known());
}

TEST_CASE("PointsOfAMergedCloudAreSeenFromTheScannerOfTheirValue") {
  const std::string content =
      "FIELDS x y z scan\nSIZE 4 4 4 1\nTYPE F F F U\nPOINTS 3\nDATA ascii\n"
      "1 2 3 0\n1 2 3 7\n1 2 3 1\n";
  ScanOptions options;
  options.with_view = true;
  options.without_attributes = true;
  options.motion.translation = {100, 0, 0};
  options.scanners = {parse_scanner_of_value("scan=0 1 2 9"),
                      parse_scanner_of_value("Scan=1 0 1 0 0")};
  const auto source = open_scan(content, options);
  PointCloud cloud;
  REQUIRE(source->read(cloud, 10));
  const auto code_of = [&](std::size_t point) {
    ViewCode code;
    std::memcpy(&code, cloud.attribute_row(point).data() + *view_offset(cloud.schema), sizeof code);
    return code;
  };
  CHECK(norm(decode_view(code_of(0)) - Vec3{0, 0, 1}) < 1e-3);
  CHECK_FALSE(code_of(1).known());
  CHECK(norm(decode_view(code_of(2)) - Vec3{0, 1, 0}) < 1e-3);
}

TEST_CASE("ScannersOfAnAttributeThatTheCloudLacksAreRefused") {
  ScanOptions options;
  options.with_view = true;
  options.scanners = {parse_scanner_of_value("scan=0 1 2 9")};
  CHECK_THROWS_WITH(open_scan(pcd_seen_from(""), options),
                    Catch::Matchers::Contains("the points have no scan") &&
                        Catch::Matchers::Contains("input.scanners"));
}

TEST_CASE("PlacesOfScannersThatAreNoneAreRefused") {
  for (const char* text :
       {"", "scan=0", "scan=0 1 2", "scan 1 2 3", "=0 1 2 3", "scan=a 1 2 3", "scan=0 1 2 3 1",
        "scan=0 0 0 0 0", "scan=0 1 2 inf", "scan=0 1 2 3 0 0"}) {
    INFO(text);
    CHECK_THROWS_AS(parse_scanner_of_value(text), std::invalid_argument);
  }
}

}  // namespace orbweave::test
