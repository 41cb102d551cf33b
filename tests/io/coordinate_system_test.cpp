// What PROJ makes of the systems that scans name, and what is written of them.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "io/clouds/point_source_list.h"
#include "io/points/coordinate_system.h"
#include "io/points/coordinate_system_file.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;

namespace orbweave {
namespace {

constexpr double kSurveyFoot = 12.0 / 39.37;

Box around(Vec3 center) { return {center - Vec3{100, 100, 10}, center + Vec3{100, 100, 10}}; }

const std::string kGrs80 =
    "GEOGCS[\"NAD83\",DATUM[\"North_American_Datum_1983\",SPHEROID[\"GRS 1980\",6378137,"
    "298.257222101]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]";
const std::string kSiteInMeters =
    "PROJCS[\"Site grid\"," + kGrs80 +
    ",PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",47],"
    "PARAMETER[\"central_meridian\",8.5],PARAMETER[\"scale_factor\",1],"
    "PARAMETER[\"false_easting\",1000],PARAMETER[\"false_northing\",2000],UNIT[\"metre\",1]]";
const std::string kSiteInFeet =
    "PROJCRS[\"County grid\",BASEGEOGCRS[\"NAD83\",DATUM[\"North American Datum 1983\","
    "ELLIPSOID[\"GRS 1980\",6378137,298.257222101]]],CONVERSION[\"c\",METHOD[\"Lambert Conic "
    "Conformal (2SP)\"],PARAMETER[\"Latitude of false origin\",41.75,ANGLEUNIT[\"degree\","
    "0.0174532925199433]],PARAMETER[\"Longitude of false origin\",-120.5,ANGLEUNIT[\"degree\","
    "0.0174532925199433]],PARAMETER[\"Latitude of 1st standard parallel\",43,ANGLEUNIT[\"degree\","
    "0.0174532925199433]],PARAMETER[\"Latitude of 2nd standard parallel\",45.5,ANGLEUNIT["
    "\"degree\",0.0174532925199433]],PARAMETER[\"Easting at false origin\",1312335.958,LENGTHUNIT["
    "\"foot\",0.3048]],PARAMETER[\"Northing at false origin\",0,LENGTHUNIT[\"foot\",0.3048]]],"
    "CS[Cartesian,2],AXIS[\"e\",east],AXIS[\"n\",north],LENGTHUNIT[\"foot\",0.3048]]";
const std::string kPlant = "LOCAL_CS[\"Plant\",UNIT[\"US survey foot\",0.304800609601219]]";

}  // namespace

TEST_CASE("TheFileOfACodeIsWktThatStandsForThatCode") {
  const test::ScratchDirectory scratch;
  const std::string code =
      GENERATE("EPSG:26912", "EPSG:32633", "EPSG:25833", "EPSG:2992", "EPSG:2994", "EPSG:2225",
               "EPSG:4326", "EPSG:2193", "EPSG:27700", "EPSG:5972", "EPSG:26912+5703");
  CAPTURE(code);
  write_coordinate_system(scratch / "mesh.ply", code);
  const std::string text = test::file_text(scratch / "mesh.prj");
  CHECK(is_wkt(text));
  CHECK(coordinate_system_beside(scratch / "mesh.ply") + "\n" == text);
  const auto read = known_coordinate_system(coordinate_system_beside(scratch / "mesh.ply"));
  REQUIRE(read);
  CHECK(systems_differ(code, text) == SystemsDiffer::kNo);
  CHECK(read->code == known_coordinate_system(code)->code);
}

TEST_CASE("TheFileOfACustomSystemIsItsOwnText") {
  const test::ScratchDirectory scratch;
  const std::string system = GENERATE(kSiteInMeters, kSiteInFeet, kPlant);
  CAPTURE(system);
  write_coordinate_system(scratch / "mesh.ply", system);
  CHECK(test::file_text(scratch / "mesh.prj") == system + "\n");
  const auto read = known_coordinate_system(coordinate_system_beside(scratch / "mesh.ply"));
  REQUIRE(read);
  CHECK(read->code.empty());
  CHECK(read->meters_per_unit.has_value());
}

TEST_CASE("UnitsAreThoseOfTheSystem") {
  const auto unit = [](const std::string& system) {
    return known_coordinate_system(system)->meters_per_unit;
  };
  CHECK(unit("EPSG:26912") == Vec3{1, 1, 1});
  CHECK(unit("EPSG:2994") == Vec3{0.3048, 0.3048, 0.3048});
  const Vec3 feet = unit("EPSG:2225").value();
  CHECK(feet.x == Approx(kSurveyFoot).epsilon(1e-14));
  CHECK(unit("EPSG:2225+5703").value().z == 1.0);
  CHECK(unit("EPSG:26912+6360").value().z == Approx(kSurveyFoot).epsilon(1e-14));
  CHECK_FALSE(unit("EPSG:4326"));
  CHECK(unit(kSiteInFeet) == Vec3{0.3048, 0.3048, 0.3048});
  CHECK(unit(kPlant).value().y == Approx(kSurveyFoot).epsilon(1e-14));
  CHECK(known_coordinate_system("EPSG:4326")->is_geographic);
  CHECK_FALSE(known_coordinate_system("EPSG:26912")->is_geographic);
}

TEST_CASE("TextsOfOneSystemAreAlikeAndOthersDiffer") {
  const std::string utm = known_coordinate_system("EPSG:26912")->wkt;
  CHECK(systems_differ("EPSG:26912", utm) == SystemsDiffer::kNo);
  CHECK(systems_differ("EPSG:26912", "EPSG:26912+5703") == SystemsDiffer::kNo);
  CHECK(systems_differ("EPSG:26912", "EPSG:26913") == SystemsDiffer::kYes);
  CHECK(systems_differ("EPSG:2992", "EPSG:2994") == SystemsDiffer::kYes);  // feet of two kinds
  CHECK(systems_differ("EPSG:26912+5703", "EPSG:26912+6360") == SystemsDiffer::kYes);
  CHECK(systems_differ("my grid", utm) == SystemsDiffer::kUnknown);
  CHECK(systems_differ("my grid", "my grid") == SystemsDiffer::kNo);
}

TEST_CASE("CoordinatesThatASystemIsNotUsedForAreObjectedTo") {
  const Box utm_points = around({448'000, 4'411'000, 1500});
  CHECK(objection_to_coordinates("EPSG:26912", utm_points).empty());
  CHECK(objection_to_coordinates(known_coordinate_system("EPSG:26912")->wkt, utm_points).empty());
  CHECK_THAT(objection_to_coordinates("EPSG:4326", utm_points), Contains("nowhere on the earth"));
  CHECK_THAT(objection_to_coordinates("EPSG:26912", around({50, 50, 0})),
             Contains("W, 0 N") && Contains("114 W, 31.33 N"));
  // Feet that are metres: the tile would lie in the Pacific.
  CHECK_THAT(objection_to_coordinates("EPSG:2225", around({609'600, 600'000, 0})), Contains("W"));
  CHECK(objection_to_coordinates("EPSG:3832", around({-400'000, -2'000'000, 0})).empty());
  CHECK(objection_to_coordinates(kSiteInMeters, around({50, 50, 0})).empty());
  CHECK(objection_to_coordinates("my grid", utm_points).empty());
}

TEST_CASE("WhatIsNoCoordinateSystemIsNeitherKnownNorWritten") {
  const test::ScratchDirectory scratch;
  for (const char* text : {"my grid", "EPSG:99999", "EPSG:", "PROJCS[", "+proj=utm +zone=12",
                           "ELLIPSOID[\"GRS 1980\",6378137,298.257222101]"})
    CHECK_FALSE(known_coordinate_system(text));
  CHECK_FALSE(known_coordinate_system("PROJCS[" + std::string(2'000'000, 'x')));
  CHECK_THAT(written_system("my grid").problem, Contains("does not know"));
  CHECK(write_coordinate_system(scratch / "mesh.ply", "my grid").empty());
  CHECK(write_coordinate_system("-", "EPSG:26912").empty());
  test::write_text(scratch / "cloud.prj", "no system\n");
  CHECK(coordinate_system_beside(scratch / "cloud.xyz").empty());
  // Heights of a system that is not known leave the rest as it is.
  CHECK(known_coordinate_system("EPSG:26912+5101")->code == "EPSG:26912");
}

TEST_CASE("AFileBesideMayNameItsSystemInAnyWayThatIsUnderstood") {
  if (!has_coordinate_database()) return;
  const test::ScratchDirectory scratch;
  const auto read = [&](const std::string& text) {
    test::write_text(scratch / "cloud.prj", text);
    return coordinate_system_beside(scratch / "cloud.xyz");
  };
  for (const std::string text : {"EPSG:32633\r\n", "epsg:32633",
                                 "\xEF\xBB\xBF"
                                 "EPSG:32633",
                                 "urn:ogc:def:crs:EPSG::32633", "WGS 84 / UTM zone 33N"}) {
    CAPTURE(text);
    CHECK(read(text) == "EPSG:32633");
    CHECK(unknown_system_beside(scratch / "cloud.xyz").empty());
  }
  CHECK(read("\xEF\xBB\xBF" + kSiteInMeters) == kSiteInMeters);
  const std::string utm = read("+proj=utm +zone=33 +datum=WGS84 +units=m");
  CHECK(systems_differ(utm, "EPSG:32633") == SystemsDiffer::kNo);
  CHECK(known_coordinate_system(read("ESRI:102008"))->name.starts_with("North_America_Albers"));
}

TEST_CASE("WordsThatAreLikeTheNameOfASystemDoNotStandForIt") {
  if (!has_coordinate_database()) return;
  for (const char* text : {"UCS", "Metric", "metric\n", "Paris", "Airport", "Zaporizhzhia"}) {
    CAPTURE(text);
    CHECK(system_of_text(text).empty());
  }
  // Texts that have the beginning of WKT alone: letters and a bracket.
  for (const char* text : {"M[", "zH(z"}) {
    CAPTURE(text);
    CHECK_FALSE(known_coordinate_system(text));
  }
  // Names in other letters, other names, and names of both parts.
  CHECK(system_of_text("wgs84/utm zone 33n") == "EPSG:32633");
  CHECK(system_of_text("WGS_1984_UTM_Zone_33N") == "EPSG:32633");
  CHECK(system_of_text("British National Grid") == "EPSG:27700");
  CHECK(system_of_text("NAD83 / UTM zone 12N + NAVD88 height") == "EPSG:26912+5703");
  CHECK(system_of_text("RGF93 / Lambert-93 + NGF-IGN69 height") ==
        system_of_text("RGF93 v1 / Lambert-93 + NGF-IGN69 height"));
  CHECK_FALSE(system_of_text("RGF93 / Lambert-93 + NGF-IGN69 height").empty());
  CHECK(known_coordinate_system("NTF (Paris)")->code == "EPSG:4807");
}

TEST_CASE("WordsBesideAFileThatNameNoSystemAreTold") {
  const test::ScratchDirectory scratch;
  test::write_text(scratch / "cloud.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  test::write_text(scratch / "cloud.prj", "Projection  UTM\r\nZone 33\n");
  CHECK(unknown_system_beside(scratch / "cloud.xyz") == "Projection UTM Zone 33");
  const std::string told =
      "cloud.prj: no coordinate system that is known, so it is passed over: "
      "Projection UTM Zone 33\n";
  CHECK_THAT(test::run_in(scratch, {"convert", "cloud.xyz", "b.ply"}).err, Contains(told));
  CHECK_THAT(test::run_in(scratch, {"inspect", "cloud.xyz"}).err, Contains(told));
  std::vector<std::string> notes;
  open_point_sources({scratch / "cloud.xyz"}, {}, &notes);
  REQUIRE(notes.size() == 1);
  CHECK_THAT(notes[0], Contains("cloud.prj names no coordinate system that is known"));
  test::write_text(scratch / "cloud.prj", "<project/>\n");
  CHECK(test::run_in(scratch, {"convert", "cloud.xyz", "b.ply"}).err.empty());
}

TEST_CASE("ProjectedCoordinatesFindTheirPlaceOnTheEarth") {
  if (!has_coordinate_database()) return;
  // The middle of zone 12 north at the equator: 111 degrees west.
  const auto equator = earth_from_local("EPSG:32612", {500'000, 0, 0});
  REQUIRE(equator);
  const std::array<double, 16>& m = *equator;
  const Vec3 place{m[12], m[13], m[14]};
  const double longitude = -111.0 * std::numbers::pi / 180.0;
  const Vec3 expected = 6378137.0 * Vec3{std::cos(longitude), std::sin(longitude), 0.0};
  CHECK(norm(place - expected) < 0.01);
  // East, north and up, as long as the map's scale on its middle meridian says.
  const Vec3 east{m[0], m[1], m[2]};
  const Vec3 north{m[4], m[5], m[6]};
  const Vec3 up{m[8], m[9], m[10]};
  CHECK(norm(up - normalized(expected)) < 1e-6);
  CHECK(norm(north - Vec3{0, 0, 1.0 / 0.9996}) < 1e-4);
  CHECK(norm(cross(east, north) - norm(east) * norm(north) * up) < 1e-6);
  CHECK(std::abs(norm(east) - 1.0 / 0.9996) < 1e-4);
  // Feet of a survey, and what has no place.
  const auto feet = earth_from_local("EPSG:2992", {636'000, 849'000, 400});
  REQUIRE(feet);
  CHECK(std::abs(norm(Vec3{(*feet)[0], (*feet)[1], (*feet)[2]}) - 0.3048) < 1e-3);
  CHECK_FALSE(earth_from_local("EPSG:4326", {10, 50, 0}));
  CHECK_FALSE(earth_from_local("", {}));
}

}  // namespace orbweave
