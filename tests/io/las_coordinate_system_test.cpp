// Where the coordinate reference system of a LAS file is found.
#include <catch2/catch.hpp>
#include <optional>

#include "io/clouds/point_source_list.h"
#include "tests/io/las_files.h"
#include "tests/support/program.h"

namespace orbweave {
namespace {

using test::LasFile;
using test::raw;
using test::variable_record;

struct GeoKey {
  unsigned id, place, count, value;
};

std::string keys_record(const std::vector<GeoKey>& keys) {
  const auto u16 = [](std::size_t v) { return raw(static_cast<std::uint16_t>(v)); };
  std::string payload = u16(1) + u16(1) + u16(0) + u16(keys.size());
  for (const GeoKey& key : keys)
    payload += u16(key.id) + u16(key.place) + u16(key.count) + u16(key.value);
  return variable_record("LASF_Projection", 34735, payload);
}

std::string ascii_record(const std::string& text) {
  return variable_record("LASF_Projection", 34737, text);
}
std::string wkt_record(const std::string& text, bool is_extended = false) {
  return variable_record("LASF_Projection", 2112, text, is_extended);
}

const std::string kWkt = "PROJCS[\"somewhere\",UNIT[\"metre\",1]]";
constexpr std::uint16_t kWktBit = 16;

std::string bytes_of(const std::vector<std::string>& records, std::uint16_t encoding,
                     const std::vector<std::string>& extended) {
  LasFile file;
  file.minor = 4;
  file.format = 6;
  file.add({});
  file.variable_records = records;
  file.extended_records = extended;
  file.global_encoding = encoding;
  return file.bytes();
}

std::string system_of(const std::vector<std::string>& records, std::uint16_t encoding = 0,
                      const std::vector<std::string>& extended = {}) {
  const std::string bytes = bytes_of(records, encoding, extended);
  return test::las_source(bytes)->coordinate_system();
}

std::optional<Vec3> unit_of(const std::vector<std::string>& records, std::uint16_t encoding = 0) {
  const std::string bytes = bytes_of(records, encoding, {});
  return test::las_source(bytes)->meters_per_unit();
}

Vec3 all(double unit) { return {unit, unit, unit}; }

TEST_CASE("ACodeOfGeoTiffKeysIsTheCoordinateSystem") {
  CHECK(system_of({keys_record({{1024, 0, 1, 1}, {3072, 0, 1, 26912}})}) == "EPSG:26912");
  CHECK(system_of({keys_record({{1024, 0, 1, 2}, {2048, 0, 1, 4326}})}) == "EPSG:4326");
  CHECK(system_of({keys_record({{2048, 0, 1, 4269}, {3072, 0, 1, 26912}})}) == "EPSG:26912");
}

TEST_CASE("TheCodeOfHeightsIsPartOfTheCoordinateSystem") {
  const auto system = [](unsigned vertical, unsigned unit) {
    return system_of(
        {keys_record({{3072, 0, 1, 26912}, {4096, 0, 1, vertical}, {4099, 0, 1, unit}})});
  };
  CHECK(system(5703, 9001) == "EPSG:26912+5703");
  CHECK(system(5103, 9001) == "EPSG:26912+5703");  // a datum, as older files have it
  CHECK(system(5703, 9003) == "EPSG:26912+6360");
  CHECK(system(5703, 9002) == "EPSG:26912+8228");
  for (const unsigned none : {0u, 5030u, 32767u, 40000u}) CHECK(system(none, 9001) == "EPSG:26912");
}

TEST_CASE("WhatAProjectionIsBasedOnIsNotTakenForTheProjection") {
  CHECK(system_of({keys_record({{1024, 0, 1, 1}, {2048, 0, 1, 4326}})}).empty());
  CHECK(system_of({keys_record({{2048, 0, 1, 4326}, {3072, 0, 1, 32767}})}).empty());
}

TEST_CASE("AUserDefinedSystemIsToldInItsOwnWords") {
  const std::string ascii = ascii_record(std::string("My grid, zone 3||WGS 84|\0\0", 26));
  CHECK(system_of({keys_record({{3072, 0, 1, 32767}, {1026, 34737, 17, 0}}), ascii}) ==
        "My grid, zone 3");
  CHECK(system_of({keys_record({{3072, 0, 1, 32767}, {1026, 34737, 17, 0}, {3073, 34737, 7, 17}}),
                   ascii}) == "WGS 84");
  CHECK(system_of({keys_record({{1024, 0, 1, 2}, {2048, 0, 1, 32767}, {2049, 34737, 7, 17}}),
                   ascii}) == "WGS 84");
  CHECK(system_of({keys_record({{3072, 0, 1, 32767}, {1026, 34737, 60000, 3}}), ascii}) ==
        "grid, zone 3||WGS 84");
  CHECK(system_of({keys_record({{3072, 0, 1, 32767}, {1026, 34737, 5, 26}}), ascii}).empty());
}

TEST_CASE("WktIsTakenWhereTheHeaderSaysSoOrKeysNameNoCode") {
  const std::string keys = keys_record({{3072, 0, 1, 26912}});
  CHECK(system_of({wkt_record(kWkt)}, kWktBit) == kWkt);
  CHECK(system_of({wkt_record(kWkt + std::string(4, '\0'))}) == kWkt);
  CHECK(system_of({keys, wkt_record(kWkt)}, kWktBit) == kWkt);
  CHECK(system_of({keys, wkt_record(kWkt)}) == "EPSG:26912");
  CHECK(system_of({keys_record({{3072, 0, 1, 32767}}), wkt_record(kWkt)}) == kWkt);
  CHECK(system_of({keys}, kWktBit) == "EPSG:26912");
}

TEST_CASE("WktIsFoundBehindThePointsToo") {
  CHECK(system_of({}, kWktBit,
                  {variable_record("someone", 9, "abc", true), wkt_record(kWkt, true)}) == kWkt);
}

TEST_CASE("WhatIsNoCoordinateSystemIsNotPassedOn") {
  CHECK(system_of({}).empty());
  for (const char* text : {"", "''", "[", "\"quoted\"", "PROJCS", "4326", "unknown  "})
    CHECK(system_of({wkt_record(text)}, kWktBit).empty());
  for (const unsigned code : {0u, 1023u, 32767u, 40000u})
    CHECK(system_of({keys_record({{2048, 0, 1, code}})}).empty());
  CHECK(system_of({variable_record("LASF_Projection", 34735, "odd")}).empty());
  CHECK(system_of({variable_record("someone else", 2112, kWkt)}, kWktBit).empty());
}

TEST_CASE("TheUnitOfGeoTiffKeysIsTheUnitOfTheCoordinates") {
  constexpr double kSurveyFoot = 12.0 / 39.37;
  const auto unit = [](unsigned code) {
    return unit_of({keys_record({{3072, 0, 1, 2225}, {3076, 0, 1, code}})});
  };
  CHECK(unit(9001) == all(1.0));
  CHECK(unit(9002) == all(0.3048));
  CHECK(unit(9003) == all(kSurveyFoot));
  CHECK_FALSE(unit(9102));  // degrees
  CHECK(unit_of({keys_record({{3072, 0, 1, 2225}, {3076, 0, 1, 9003}, {4099, 0, 1, 9001}})}) ==
        Vec3{kSurveyFoot, kSurveyFoot, 1.0});
}

TEST_CASE("AUnitThatIsNotSaidIsThatOfTheCode") {
  CHECK_FALSE(unit_of({}));
  CHECK_FALSE(unit_of({keys_record({{1024, 0, 1, 1}, {3072, 0, 1, 32767}})}));
  CHECK(unit_of({keys_record({{3072, 0, 1, 2994}})}) == all(0.3048));
  CHECK(unit_of({keys_record({{3072, 0, 1, 2994}, {4096, 0, 1, 5703}})}) ==
        Vec3{0.3048, 0.3048, 1.0});
  CHECK_FALSE(unit_of({keys_record({{1024, 0, 1, 2}, {2048, 0, 1, 4326}, {3076, 0, 1, 9001}})}));
  for (const unsigned utm : {26912u, 32601u, 32760u, 25832u})
    CHECK(unit_of({keys_record({{3072, 0, 1, utm}})}) == all(1.0));
  CHECK(unit_of({keys_record({{3072, 0, 1, 26912}, {3076, 0, 1, 9002}})}) == all(0.3048));
}

TEST_CASE("TheUnitOfWktIsThatOfTheProjectionNotOfItsBase") {
  const std::string base =
      "GEOGCS[\"NAD83\",DATUM[\"D\",SPHEROID[\"GRS 1980\",6378137,298.257222101],"
      "TOWGS84[0,0,0,0,0,0,0]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]";
  const std::string feet = "PROJCS[\"California 1 (ftUS)\"," + base +
                           ",PROJECTION[\"Lambert\"],PARAMETER[\"false_easting\",6561666.667],"
                           "UNIT[\"US survey foot\",0.304800609601219],AXIS[\"X\",EAST]]";
  const auto unit = [](const std::string& wkt) { return unit_of({wkt_record(wkt)}, kWktBit); };
  CHECK(unit(kWkt) == all(1.0));
  CHECK(unit(feet) == all(0.304800609601219));
  CHECK(unit("COMPD_CS[\"both\"," + feet +
             ",VERT_CS[\"NAVD88\",VERT_DATUM[\"V\",2005],UNIT[\"metre\",1.0]]]") ==
        Vec3{0.304800609601219, 0.304800609601219, 1.0});
  CHECK(unit("PROJCRS[\"a \"\"new\"\" one\",BASEGEOGCRS[\"b\",ANGLEUNIT[\"degree\",0.0174]],"
             "CONVERSION[\"c\",PARAMETER[\"e\",0,LENGTHUNIT[\"metre\",1]]],CS[Cartesian,2],"
             "AXIS[\"x\",east,ORDER[1],LENGTHUNIT[\"foot\",0.3048]],"
             "AXIS[\"y\",north,ORDER[2],LENGTHUNIT[\"foot\",0.3048]]]") == all(0.3048));
  CHECK_FALSE(unit(base));
  // Damaged text says nothing.
  for (const char* wkt : {"PROJCS[\"a\",UNIT[\"b\",1", "PROJCS[\"a\",UNIT[\"b\",0]]", "PROJCS[\"a",
                          "PROJCS[;]", "PROJCS[UNIT[\"b\",inf]]", "PROJCS[]"})
    CHECK_FALSE(unit(wkt));
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep += "COMPD_CS[";
  CHECK_FALSE(unit(deep));
}

TEST_CASE("TheUnitOfScansWithoutASystemIsTheOneThatAllSayWhateverTheirOrder") {
  const test::ScratchDirectory scratch;
  const auto written = [&](const std::string& name, const std::vector<std::string>& records) {
    test::write_text(scratch / name, bytes_of(records, 0, {}));
    return scratch / name;
  };
  const auto feet = written("feet.las", {keys_record({{3072, 0, 1, 32767}, {3076, 0, 1, 9002}})});
  const auto metres = written("m.las", {keys_record({{3072, 0, 1, 32767}, {3076, 0, 1, 9001}})});
  const auto silent = written("none.las", {});
  const auto unit = [](const std::vector<std::filesystem::path>& files) {
    const auto list = open_point_sources(files);
    CHECK(list->coordinate_system().empty());
    return list->meters_per_unit();
  };
  CHECK(unit({feet}) == all(0.3048));
  CHECK(unit({feet, silent}) == all(0.3048));
  CHECK(unit({silent, feet}) == all(0.3048));
  CHECK_FALSE(unit({feet, metres}));
  CHECK_FALSE(unit({metres, feet}));
}

}  // namespace
}  // namespace orbweave
