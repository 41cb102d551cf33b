// Areas of polygons: which points they hold, and how they are written.
#include "io/points/polygon_area.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "io/error.h"
#include "io/points/area_text.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

namespace orbweave::test {
namespace {

using Catch::Contains;

PolygonArea area(const std::string& text) { return PolygonArea(parse_area(text, "a.wkt")); }

const std::string kRingWithHole =
    "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0), (4 4, 6 4, 6 6, 4 6, 4 4))";

std::string message_of(const std::string& text) {
  try {
    parse_area(text, "a.wkt");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kBadInput);
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("AnAreaHoldsItsInsideWithoutItsHoles") {
  const PolygonArea square = area(kRingWithHole);
  CHECK(square.contains(1, 1));
  CHECK(square.contains(3.999, 5));
  CHECK_FALSE(square.contains(5, 5));
  CHECK_FALSE(square.contains(-1e-9, 5));
  CHECK_FALSE(square.contains(11, 5));
  CHECK_FALSE(square.contains(5, 1e300));
  CHECK_FALSE(square.contains(std::nan(""), 5));
}

TEST_CASE("APointOnAnEdgeIsInsideOfAHoleToo") {
  const PolygonArea square = area(kRingWithHole);
  for (const double place : {0.0, 2.5, 4.0, 5.0, 6.0, 10.0}) {
    CAPTURE(place);
    CHECK(square.contains(place, 0));
    CHECK(square.contains(place, 10));
    CHECK(square.contains(0, place));
    CHECK(square.contains(10, place));
  }
  CHECK(square.contains(4, 5));
  CHECK(square.contains(5, 6));
  CHECK(square.contains(6, 6));
}

TEST_CASE("APointBesideASlantedEdgeIsToldFromItExactly") {
  // No double is exactly on this edge but its ends and those of equal fractions.
  const PolygonArea triangle = area("POLYGON ((0 0, 3 1, 0 1))");
  const double third = 1.0 / 3.0;  // below one third
  CHECK(triangle.contains(1.0, std::nextafter(third, 1.0)));
  CHECK_FALSE(triangle.contains(1.0, third));
  CHECK(triangle.contains(1.5, 0.5));
  CHECK_FALSE(triangle.contains(std::nextafter(1.5, 2.0), 0.5));
  CHECK(triangle.contains(std::nextafter(1.5, 1.0), 0.5));
  // Far from the origin, where differences are rounded.
  const PolygonArea far = area("POLYGON ((5000000.1 0.3, 5000007.3 0.9, 5000000.1 0.9))");
  CHECK(far.contains(5000000.1, 0.3));
  CHECK(far.contains(5000007.3, 0.9));
}

TEST_CASE("NeighboursThatShareAnEdgeHoldEveryPointBetweenThem") {
  const PolygonArea both = area("MULTIPOLYGON (((0 0, 7 0, 3.3 9.1)), ((7 0, 12.7 8.9, 3.3 9.1)))");
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const double t = static_cast<double>(random() % 100000) / 100000.0;
    CHECK(both.contains(7.0 + t * (3.3 - 7.0), t * 9.1));
  }
}

TEST_CASE("AnAreaOfManyEdgesIsTheSameAsTryingThemAll") {
  std::mt19937_64 random(5);
  std::string text = "POLYGON ((";
  std::vector<AreaPoint> ring;
  constexpr int kCorners = 700;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2.0 * 3.141592653589793 * i / kCorners;
    const double radius = 50.0 + static_cast<double>(random() % 4000) / 100.0;
    ring.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  const PolygonArea star({{ring, {}}});
  for (int i = 0; i < 5000; ++i) {
    const double x = static_cast<double>(random() % 200000) / 1000.0 - 100.0;
    const double y = static_cast<double>(random() % 200000) / 1000.0 - 100.0;
    // The ring is star-shaped: the sector of the point decides.
    const double angle = std::atan2(y, x) / (2.0 * 3.141592653589793) * kCorners;
    const int sector =
        static_cast<int>(std::floor(angle < 0 ? angle + kCorners : angle)) % kCorners;
    const AreaPoint a = ring[static_cast<std::size_t>(sector)];
    const AreaPoint b = ring[static_cast<std::size_t>((sector + 1) % kCorners)];
    const double side = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
    if (std::abs(side) < 1e-6) continue;
    CHECK(star.contains(x, y) == (side > 0));
  }
}

TEST_CASE("OverlappingPolygonsAreOneArea") {
  const PolygonArea both = area("POLYGON ((0 0, 4 0, 4 4, 0 4)); POLYGON ((2 2, 6 2, 6 6, 2 6))");
  CHECK(both.contains(3, 3));
  CHECK(both.contains(1, 1));
  CHECK(both.contains(5, 5));
  CHECK_FALSE(both.contains(5, 1));
}

TEST_CASE("WktIsTakenWithItsDimensionsAndItsSystem") {
  for (const char* text :
       {"POLYGON((0 0,2 0,2 2,0 2,0 0))", "  polygon  ( ( 0 0 , 2 0 , 2 2 , 0 2 ) )\n",
        "SRID=26910;POLYGON ((0 0, 2 0, 2 2, 0 2))", "POLYGON Z ((0 0 9, 2 0 9, 2 2 9, 0 2 9))",
        "POLYGON ZM ((0 0 9 1, 2 0 9 1, 2 2 9 1, 0 2 9 1))",
        "\xef\xbb\xbfMULTIPOLYGON (((0 0, 2e0 0, +2 2, 0 2)))",
        R"({"type": "Polygon", "coordinates": [[[0, 0], [2, 0, 7], [2, 2], [0, 2], [0, 0]]]})",
        R"({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"n": 1},
            "geometry": {"coordinates": [[[[0, 0], [2, 0], [2, 2], [0, 2]]]], "type": "MultiPolygon"}}]})",
        R"({"type": "FeatureCollection", "features": [
            {"type": "Feature", "geometry": null, "properties": null}, {"type": "Feature",
            "geometry": {"type": "Polygon", "coordinates": [[[0, 0], [2, 0], [2, 2], [0, 2]]]}}]})",
        R"({"type": "GeometryCollection", "geometries": [{"type": "Polygon",
            "coordinates": [[[0, 0], [2, 0], [2, 2], [0, 2]]]}]})"}) {
    CAPTURE(text);
    const PolygonArea square = area(text);
    CHECK(square.bounds().min.x == 0.0);
    CHECK(square.bounds().max.y == 2.0);
    CHECK(square.contains(1, 1));
    CHECK_FALSE(square.contains(3, 1));
  }
}

TEST_CASE("TextThatIsNoAreaIsRefusedWithItsPlace") {
  CHECK_THAT(message_of("POLYGON ((0 0, 1 0, x 1))"),
             Contains("a.wkt: line 1, column 21: this is no corner of a polygon; found \"x 1))\""));
  CHECK_THAT(message_of("POLYGON ((0 0, 1 0))"),
             Contains("a ring has too few corners") && Contains("at least three"));
  CHECK_THAT(message_of("POLYGON ((0 0, 1 0, 0 0))"), Contains("too few corners"));
  CHECK_THAT(message_of("\nPOINT (1 2)"),
             Contains("line 2, column 1") && Contains("expected POLYGON or MULTIPOLYGON"));
  CHECK_THAT(message_of("POLYGON EMPTY"), Contains("holds no points"));
  CHECK_THAT(message_of("POLYGON ((0 0, 1 0, 1 1)"), Contains("found the end, expected ')'"));
  CHECK_THAT(message_of("POLYGON ((0 0, 1 0, 1 1)) and more"), Contains("column 27"));
  CHECK_THAT(message_of("POLYGON ((0 0, 1e99 0, 1 1))"), Contains("up to 1e75"));
  CHECK_THAT(message_of(""), Contains("found the end"));
  CHECK_THAT(message_of("SRID=1"), Contains("found the end"));
  CHECK_THAT(message_of("{"), Contains("this is no JSON") && Contains("byte "));
  CHECK_THAT(message_of("{}"), Contains("the document") && Contains("found type null"));
  CHECK_THAT(message_of(R"({"type": "Point", "coordinates": [1, 2]})"), Contains("\"Point\""));
  CHECK_THAT(message_of(R"({"type": "FeatureCollection", "features": []})"),
             Contains("holds no points"));
  CHECK_THAT(message_of(R"({"type": "FeatureCollection", "features": [{"type": "Feature",
                            "geometry": null}]})"),
             Contains("holds no points"));
  CHECK_THAT(message_of(R"({"type": "FeatureCollection", "features": [{"type": "Feature"}]})"),
             Contains("geometry of features[0]"));
  CHECK_THAT(message_of(R"({"type": "Feature", "geometry": null})"),
             Contains("geometry of the document") && Contains("found null, expected an object"));
  CHECK_THAT(message_of(R"({"type": "Polygon", "coordinates": [[[0, 0], [1, "y"], [1, 1]]]})"),
             Contains("the document, ring 1, corner 2"));
  CHECK_THAT(message_of(R"({"type": "Polygon", "coordinates": [[[0, 0], [1, 1]]]})"),
             Contains("ring 1") && Contains("found 2"));
  CHECK_THAT(message_of("POLYGON ((" + std::string(kMostAreaBytes, ' ')),
             Contains("the area is too large"));
  std::string corners = "POLYGON ((0 0";
  for (std::size_t i = 0; i < kMostAreaCorners; ++i) corners += ",1 1";
  CHECK_THAT(message_of(corners + "))"), Contains("131,073 corners"));
  CHECK_THAT(message_of("{" + std::string(kMostAreaBytes / 4, '[')),
             Contains("the area is too large"));
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  for (const std::string start :
       {R"({"type": )", R"({"type": "Polygon", "coordinates": )", R"({"type": "Point", "x": )"})
    CHECK_THAT(message_of(start + deep + "}"), Contains("a.wkt: the area is nested too deeply"));
}

TEST_CASE("AnAreaIsTextOrTheNameOfAFile") {
  CHECK(is_area_text("POLYGON ((0 0, 1 0, 1 1))"));
  CHECK(is_area_text(" multipolygon(((0 0, 1 0, 1 1)))"));
  CHECK(is_area_text("SRID=26910;POLYGON ((0 0, 1 0, 1 1))"));
  CHECK(is_area_text(" srid=2992; MULTIPOLYGON (((0 0, 1 0, 1 1)))"));
  CHECK_FALSE(is_area_text("SRID=26910;area.wkt"));
  CHECK_FALSE(is_area_text("srid.wkt"));
  CHECK_FALSE(is_area_text("polygons.wkt"));
  CHECK_FALSE(is_area_text("polygon"));
  CHECK_FALSE(is_area_text("area.geojson"));
  const ScratchDirectory in;
  write_text(in / "a.wkt", "POLYGON ((0 0, 2 0, 2 2, 0 2))\n");
  CHECK(read_area(in / "a.wkt").size() == 1);
  CHECK_THROWS_WITH(read_area(in / "none.wkt"), Contains("cannot open the file of the area"));
  CHECK_THROWS_WITH(read_area(in.path()), Contains("cannot open the file of the area"));
}

}  // namespace orbweave::test
