// Which points of a scan are wanted: classes, places, one in so many.
#include "io/clouds/scan_selection.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "io/clouds/pcd_source.h"
#include "io/points/area_text.h"
#include "io/text/quantity.h"
#include "tests/io/las_files.h"

namespace orbweave::test {
namespace {

using Catch::Contains;

std::unique_ptr<PointSource> open_pcd(const std::string& content) {
  return open_pcd_source(ByteReader(memory_byte_source(std::as_bytes(std::span(content)), "a")));
}

/// The points of a PCD text that a selection keeps, by x; `dropped` gets the others.
std::vector<double> kept_of(const std::string& content, const ScanOptions& options,
                            DroppedPoints* dropped = nullptr) {
  const auto source = open_scan_source(open_pcd(content), options, "a.pcd");
  std::vector<double> kept;
  for (PointCloud batch; source->read(batch, 3);)
    for (const Vec3& p : batch.positions) kept.push_back(p.x);
  if (dropped != nullptr) *dropped = source->left_out();
  return kept;
}

std::string pcd_of(const std::vector<Vec3>& points) {
  std::string text = "FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH " +
                     std::to_string(points.size()) + "\nDATA ascii\n";
  for (const Vec3& p : points)
    text += format_exact(p.x) + " " + format_exact(p.y) + " " + format_exact(p.z) + "\n";
  return text;
}

const std::string kClasses =
    "FIELDS x y z classification\nSIZE 4 4 4 1\nTYPE F F F U\nWIDTH 5\nDATA ascii\n"
    "0 0 0 2\n1 0 0 7\n2 0 0 18\n3 0 0 7\n4 0 0 6\n";

std::shared_ptr<const PolygonArea> area(const std::string& text) {
  return std::make_shared<const PolygonArea>(parse_area(text, "a"));
}

std::vector<Vec3> scattered(std::size_t count) {
  std::mt19937_64 random(7);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<double>(random() % 100000) / 100.0;
    points.push_back(p);
  }
  return points;
}

/// A LAS file of points on a line along x, from `first` on, one unit apart.
std::string las_line(int first, int count, Box bounds) {
  LasFile file{.minor = 2, .format = 0};
  file.scale = {1.0, 1.0, 1.0};
  for (int i = 0; i < count; ++i) {
    LasPoint point;
    point.xyz = {first + i, 0, 0};
    file.add(point);
  }
  std::string bytes = file.bytes();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double max = bounds.max[static_cast<int>(axis)];
    const double min = bounds.min[static_cast<int>(axis)];
    bytes.replace(179 + 16 * axis, 8, raw(max));
    bytes.replace(187 + 16 * axis, 8, raw(min));
  }
  return bytes;
}

}  // namespace

TEST_CASE("DroppedClassesAreLeftOutAndCountedByName") {
  DroppedPoints dropped;
  CHECK(kept_of(kClasses, {.dropped_classes = {7, 18}}, &dropped) == std::vector<double>{0, 4});
  CHECK(dropped ==
        DroppedPoints{{"class 7 (low point) left out", 2}, {"class 18 (high noise) left out", 1}});
}

TEST_CASE("ClassesThatAreNamedAreKeptEvenIfTheyAreNoise") {
  CHECK(kept_of(kClasses, {.classes = {7, 6}, .dropped_classes = {7, 18}}) ==
        std::vector<double>{1, 3, 4});
}

TEST_CASE("ClassesOfCloudComparesScalarFieldsAreClasses") {
  std::string cloud_compare = kClasses;
  cloud_compare.replace(cloud_compare.find("classification"), 14, "scalar_Classification");
  CHECK(kept_of(cloud_compare, {.dropped_classes = {7, 18}}) == std::vector<double>{0, 4});
  CHECK(kept_of(cloud_compare, {.classes = {6}}) == std::vector<double>{4});
  // An attribute of that very name comes first.
  const std::string both =
      "FIELDS x y z scalar_Classification Classification\nWIDTH 2\nDATA ascii\n"
      "0 0 0 7 2\n1 0 0 2 7\n";
  CHECK(kept_of(both, {.dropped_classes = {7}}) == std::vector<double>{0});
}

TEST_CASE("DroppingClassesAsksForNone") {
  CHECK(kept_of(pcd_of({{1, 2, 3}}), {.dropped_classes = {7, 18}}) == std::vector<double>{1});
  // What is no class is no class that is dropped.
  const std::string odd =
      "FIELDS x y z classification\nWIDTH 3\nDATA ascii\n0 0 0 nan\n1 0 0 7\n2 0 0 -3\n";
  CHECK(kept_of(odd, {.dropped_classes = {7, 18}}) == std::vector<double>{0, 2});
}

TEST_CASE("ACropKeepsItsLimitsAndLeavesWhatHasNoPlaceToOthers") {
  const std::string points =
      "FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 6\nDATA ascii\n"
      "0 0 0\n1 1 1\n2 2 2\n3 3 3\n4 nan 4\n1.5 1.5 9\n";
  DroppedPoints dropped;
  CHECK(kept_of(points, {.crop = Box{{1, 1, 1}, {2, 2, 2}}}, &dropped) ==
        std::vector<double>{1, 2, 4});
  CHECK(dropped == DroppedPoints{{kOutsideCrop, 3}});
}

TEST_CASE("ACropIsInWorldCoordinates") {
  ScanOptions options;
  options.motion = motion_of_quaternion({0, 0, 1, 1}, {100, 0, 0});  // x to y
  options.crop = Box{{99.5, 4.5, -1}, {100.5, 5.5, 1}};
  const auto source =
      open_scan_source(open_pcd(pcd_of({{0, 0, 0}, {5, 0, 0}, {100, 5, 0}})), options, "a.pcd");
  PointCloud kept;
  REQUIRE(source->read(kept, 10));
  REQUIRE(kept.size() == 1);
  CHECK(norm(kept.positions[0] - Vec3{100, 5, 0}) < 1e-9);
}

TEST_CASE("ThePlaceIsTheFirstReasonOfAPointThatHasTwo") {
  DroppedPoints dropped;
  kept_of(kClasses, {.dropped_classes = {7}, .crop = Box{{2, 0, 0}, {9, 9, 9}}}, &dropped);
  CHECK(dropped == DroppedPoints{{kOutsideCrop, 2}, {"class 7 (low point) left out", 1}});
}

TEST_CASE("OneInSoManyPointsDoesNotDependOnTheirOrder") {
  std::vector<Vec3> points = scattered(20000);
  const auto chosen = [&](std::uint64_t every) {
    ScanOptions options;
    options.every = every;
    std::vector<double> kept = kept_of(pcd_of(points), options);
    std::sort(kept.begin(), kept.end());
    return kept;
  };
  const std::vector<double> tenth = chosen(10), twentieth = chosen(20);
  CHECK(tenth.size() > 1850);
  CHECK(tenth.size() < 2150);
  CHECK(std::ranges::includes(tenth, twentieth));
  std::shuffle(points.begin(), points.end(), std::mt19937_64(3));
  CHECK(chosen(10) == tenth);
  CHECK(chosen(1).size() == points.size());
}

TEST_CASE("SelectionIsTheSameForAnyBatch") {
  const std::vector<Vec3> points = scattered(500);
  ScanOptions options;
  options.area = area("POLYGON ((0 0, 900 100, 500 900, 0 0))");
  options.every = 2;
  std::vector<std::vector<Vec3>> kept;
  for (const std::size_t capacity : {1, 7, 1000}) {
    const auto source = open_scan_source(open_pcd(pcd_of(points)), options, "a.pcd");
    kept.emplace_back();
    for (PointCloud batch; source->read(batch, capacity);)
      kept.back().insert(kept.back().end(), batch.positions.begin(), batch.positions.end());
  }
  CHECK(kept[0].size() > 20);
  CHECK(kept[1] == kept[0]);
  CHECK(kept[2] == kept[0]);
}

TEST_CASE("ALasFileOutsideOfTheCropIsPassedOverByItsHeader") {
  const Box truth{{100, 0, 0}, {199, 0, 0}};
  const auto left = [](const std::string& bytes, const ScanOptions& options) {
    const auto source = open_scan_source(
        open_las_source(memory_random_access(std::as_bytes(std::span(bytes)), "a.las")), options,
        "a.las");
    std::uint64_t points = 0;
    for (PointCloud batch; source->read(batch, 30);) points += batch.size();
    return std::pair(points, source->left_out());
  };
  ScanOptions far;
  far.crop = Box{{0, -1, -1}, {50, 1, 1}};
  using Found = std::pair<std::uint64_t, DroppedPoints>;
  CHECK(left(las_line(100, 100, truth), far) == Found{0, {{kOutsideCrop, 100}}});
  // The very same counts where the header says nothing.
  CHECK(left(las_line(100, 100, Box{{0, 0, 0}, {0, 0, 0}}), far) ==
        Found{0, {{kOutsideCrop, 100}}});
  // A header that its points contradict is not believed.
  CHECK(left(las_line(0, 100, truth), far) == Found{51, {{kOutsideCrop, 49}}});
  ScanOptions near;
  near.crop = Box{{150, -1, -1}, {500, 1, 1}};
  CHECK(left(las_line(100, 100, truth), near) == Found{50, {{kOutsideCrop, 50}}});
}

}  // namespace orbweave::test
