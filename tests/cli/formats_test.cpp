// What a surveyor's files come out as: coordinates, colours, attributes and coordinate systems.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/pipeline/surface/in_core_methods.h"
#include "io/clouds/open_point_source.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/shift_file.h"
#include "io/points/coordinate_system.h"
#include "tests/io/las_files.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using Catch::Matchers::Matches;
using Catch::Matchers::StartsWith;
using namespace orbweave;
using namespace orbweave::test;
using Json = nlohmann::json;

namespace {

using Arguments = std::vector<std::string>;

/// GeoTIFF keys of shorts.
std::string keys_record(const std::vector<std::pair<unsigned, unsigned>>& keys) {
  const auto u16 = [](std::size_t v) { return raw(static_cast<std::uint16_t>(v)); };
  std::string payload = u16(1) + u16(1) + u16(0) + u16(keys.size());
  for (const auto& [id, value] : keys) payload += u16(id) + u16(0) + u16(1) + u16(value);
  return variable_record("LASF_Projection", 34735, payload);
}

constexpr unsigned kUtm12 = 26912;
const std::array<double, 3> kSalt{448'000.0, 4'511'000.0, 1300.0};

struct Tile {
  unsigned epsg = kUtm12;  ///< 0: none is named
  int format = 2;
  std::array<double, 3> place = kSalt;
  std::uint16_t brightest = 65'535;
};

/// Ground of 24 x 24 points, 0.5 apart, coloured from black to `brightest`.
void write_tile(const std::filesystem::path& path, const Tile& tile = {}) {
  LasFile file{.minor = 2, .format = tile.format};
  if (tile.epsg == 4326)
    file.variable_records = {keys_record({{1024, 2}, {2048, 4326}})};
  else if (tile.epsg != 0)
    file.variable_records = {keys_record({{1024, 1}, {3072, tile.epsg}})};
  file.scale = {0.001, 0.001, 0.001};
  file.offset = tile.place;
  Random random(11);
  for (int i = 0; i < 576; ++i) {
    LasPoint point;
    point.xyz = {500 * (i % 24) + static_cast<int>(random.below(60)),
                 500 * (i / 24) + static_cast<int>(random.below(60)),
                 static_cast<int>(random.below(100))};
    point.return_number = point.number_of_returns = 1;
    point.classification = i % 2 == 0 ? 2 : 6;
    point.intensity = static_cast<std::uint16_t>(i);
    point.gps_time = 1000.0 + i;
    const auto value = static_cast<std::uint16_t>(i * tile.brightest / 575);
    point.rgb_nir = {value, static_cast<std::uint16_t>(tile.brightest - value), 0, 0};
    file.add(point);
  }
  std::ofstream(path, std::ios::binary) << file.bytes();
}

ProgramResult reconstruct(const ScratchDirectory& in, const Arguments& scans,
                          const std::string& mesh, const Arguments& more = {},
                          const Arguments& environment = {}) {
  Arguments all = {"reconstruct", "--up", "0,0,1", "-o", mesh};
  all.insert(all.end(), scans.begin(), scans.end());
  all.insert(all.end(), more.begin(), more.end());
  return run_program(all, {.directory = in.path(), .environment = environment});
}

Json report_of(const ScratchDirectory& in) { return Json::parse(file_text(in / "r.json")); }

std::vector<std::string> names_of(const PointSchema& schema) {
  std::vector<std::string> names;
  for (const AttributeField& field : schema.attributes) names.push_back(field.name);
  return names;
}

/// Farthest distance of a vertex of one mesh from the same vertex of the other.
double largest_distance(const TriangleMesh& a, const TriangleMesh& b) {
  REQUIRE(a.vertices.size() == b.vertices.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < a.vertices.size(); ++i)
    largest = std::max(largest, norm(a.vertices.positions[i] - b.vertices.positions[i]));
  return largest;
}

}  // namespace

TEST_CASE("ScansOfDifferentSystemsAreRefusedBeforeAnyWork") {
  const ScratchDirectory in;
  write_tile(in / "a.las");
  write_tile(in / "b.las", {.epsg = 26913});
  for (const char* command : {"reconstruct", "plan"}) {
    Arguments all = {command, "a.las", "b.las"};
    if (all.front() == "reconstruct") all.insert(all.end(), {"-o", "m.ply"});
    const ProgramResult result = run_in(in, all);
    CHECK(result.status == 3);
    CHECK_THAT(result.err, Contains("b.las: the scans of one job are in different coordinate") &&
                               Contains("found NAD83 / UTM zone 13N, EPSG:26913") &&
                               Contains("expected NAD83 / UTM zone 12N, EPSG:26912 as in a.las") &&
                               Contains("pdal translate b.las reprojected.laz reprojection "
                                        "--filters.reprojection.out_srs=EPSG:26912"));
  }
  CHECK(names_in(in) == Arguments{"a.las", "b.las"});
}

TEST_CASE("AScanWithoutASystemIsTakenForThatOfTheOthers") {
  const ScratchDirectory in;
  write_tile(in / "a.las");
  write_tile(in / "b.las", {.epsg = 0, .place = {448'012.0, 4'511'000.0, 1300.0}});
  const ProgramResult result = reconstruct(in, {"a.las", "b.las"}, "m.ply", {"--report", "r.json"});
  CHECK(result.status == 0);
  CHECK_THAT(report_of(in)["notes"].dump(),
             Contains("b.las names no coordinate system; taken to be in that of a.las"));
  CHECK(known_coordinate_system(file_text(in / "m.prj"))->code == "EPSG:26912");
  CHECK_THAT(run_in(in, {"inspect", "m.ply"}).out, Contains("NAD83 / UTM zone 12N"));
  const auto told = run_in(in, {"inspect", "m.ply", "--json"});
  const auto system = Json::parse(told.out)["coordinate_system"].get<std::string>();
  CHECK(known_coordinate_system(system)->code == "EPSG:26912");
}

TEST_CASE("CoordinatesThatDoNotFitTheirSystemAreWarnedOf") {
  const ScratchDirectory in;
  write_tile(in / "utm.las", {.epsg = 4326});
  const ProgramResult result = reconstruct(in, {"utm.las"}, "m.ply");
  CHECK(result.status == 0);
  CHECK_THAT(result.err, Contains("the coordinate system of the scans, WGS 84, hardly fits their "
                                  "coordinates: they would lie nowhere on the earth"));
  write_tile(in / "local.las", {.place = {0, 0, 0}});
  CHECK_THAT(reconstruct(in, {"local.las"}, "l.ply").err,
             Contains("NAD83 / UTM zone 12N, hardly fits") && Contains("they would lie around"));
  write_tile(in / "right.las");
  CHECK_THAT(reconstruct(in, {"right.las"}, "n.ply").err, !Contains("hardly fits"));
}

TEST_CASE("TheReportIsInMetersWhateverTheUnitOfTheSystem") {
  const ScratchDirectory in;
  const auto extent = [&](unsigned epsg, const std::array<double, 3>& place) {
    write_tile(in / "t.las", {.epsg = epsg, .place = place});
    REQUIRE(reconstruct(in, {"t.las"}, "m.ply", {"--report", "r.json"}).status == 0);
    const Json input = report_of(in)["input"];
    return input["extent_meters"][0].get<double>() / input["extent"][0].get<double>();
  };
  CHECK(extent(26912, kSalt) == 1.0);
  CHECK(extent(2994, {636'000, 849'000, 400}) == Approx(0.3048).epsilon(1e-12));
  CHECK(extent(2225, {6'000'000, 2'000'000, 400}) == Approx(12.0 / 39.37).epsilon(1e-12));
}

TEST_CASE("WithoutTheDatabaseOfProjACodeStaysACodeAndThatIsSaid") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  const Arguments nowhere = {"PROJ_DATA=/nonexistent", "PROJ_LIB=/nonexistent"};
  const ProgramResult result = reconstruct(in, {"t.las"}, "m.ply", {"--report", "r.json"}, nowhere);
  CHECK(result.status == 0);
  if (known_coordinate_system(file_text(in / "m.prj"))->wkt != file_text(in / "m.prj")) {
    CHECK(report_of(in)["coordinate_system"] == "EPSG:26912");
    CHECK(report_of(in)["input"]["extent_meters"] == report_of(in)["input"]["extent"]);  // UTM
  }
}

TEST_CASE("ConvertAndFillKeepTheCoordinateSystem") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  REQUIRE(run_in(in, {"convert", "t.las", "cloud.ply"}).status == 0);
  CHECK(known_coordinate_system(file_text(in / "cloud.prj"))->code == "EPSG:26912");
  // Read again from beside the file, by every command.
  REQUIRE(reconstruct(in, {"cloud.ply"}, "mesh.ply", {"--report", "r.json"}).status == 0);
  CHECK(file_text(in / "mesh.prj") == file_text(in / "cloud.prj"));
  CHECK(report_of(in)["input"]["extent_meters"] == report_of(in)["input"]["extent"]);
  REQUIRE(run_in(in, {"fill", "mesh.ply", "-o", "filled.obj"}).status == 0);
  REQUIRE(run_in(in, {"convert", "filled.obj", "last.stl"}).status == 0);
  CHECK(file_text(in / "filled.prj") == file_text(in / "cloud.prj"));
  CHECK(file_text(in / "last.prj") == file_text(in / "cloud.prj"));
  write_tile(in / "other.las", {.epsg = 26913});
  CHECK(run_in(in, {"plan", "cloud.ply", "other.las"}).status == 3);
}

TEST_CASE("FloatFormatsAreWrittenAroundAStatedOrigin") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  REQUIRE(reconstruct(in, {"t.las"}, "m.ply").status == 0);
  CHECK_FALSE(std::filesystem::exists(in / "m.ply.shift.txt"));
  const TriangleMesh exact = read_mesh(in / "m.ply");
  const auto check = [&](const std::string& mesh, const ProgramResult& result) {
    CAPTURE(mesh, result.err);
    REQUIRE(result.status == 0);
    const Vec3 origin = origin_beside(in / mesh);
    CHECK(origin.x == 448'006.0);
    CHECK(origin.y == 4'511'006.0);
    const TriangleMesh moved = read_mesh(in / mesh);  // in coordinates of the world
    if (mesh.ends_with(".stl")) {
      // Another order of vertices: each lies close to one of the mesh.
      CHECK(moved.vertices.size() <= exact.vertices.size());
      CHECK(moved.triangles.size() == exact.triangles.size());
      return;
    }
    CHECK(largest_distance(exact, moved) < 0.5e-3);
    CHECK_THAT(file_text(in / mesh).substr(0, 300), Contains("comment origin 448006 4511006"));
  };
  check("s.stl", reconstruct(in, {"t.las"}, "s.stl", {"--report", "r.json"}));
  CHECK(report_of(in)["origin"][0] == 448'006.0);
  CHECK_THAT(report_of(in)["notes"].dump(), Contains("are counted from 448006, 4511006"));
  check("f.ply", reconstruct(in, {"t.las"}, "f.ply", {"--precision", "float"}));
  check("c.ply", run_in(in, {"convert", "m.ply", "c.ply", "--float"}));
  check("c.stl", run_in(in, {"convert", "m.ply", "c.stl"}));
  check("h.stl", run_in(in, {"fill", "m.ply", "-o", "h.stl"}));
  // Back from there, coordinates are those of the world again.
  REQUIRE(run_in(in, {"convert", "c.ply", "back.ply"}).status == 0);
  CHECK(largest_distance(exact, read_mesh(in / "back.ply")) < 0.5e-3);
  CHECK_FALSE(std::filesystem::exists(in / "back.ply.shift.txt"));
  // As a scan, too.
  REQUIRE(reconstruct(in, {"f.ply"}, "again.ply").status == 0);
  CHECK(read_mesh(in / "again.ply").vertices.bounds().min.x > 447'000.0);
}

TEST_CASE("WithoutAnOriginFloatsAreRefusedAndAGivenOneIsTaken") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  const ProgramResult refused = reconstruct(in, {"t.las"}, "m.stl", {"--origin", "none"});
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Contains("m.stl") && Contains("--origin") && Contains("up to 0.25") &&
                              Contains("at most a thousandth of the spacing"));
  CHECK_FALSE(std::filesystem::exists(in / "m.stl"));
  REQUIRE(run_in(in, {"convert", "t.las", "t.ply"}).status == 0);
  CHECK(run_in(in, {"convert", "t.ply", "f.ply", "--float", "--origin", "none"}).status == 2);
  REQUIRE(reconstruct(in, {"t.las"}, "g.ply", {"--origin", "448000,4511000,0"}).status == 0);
  CHECK(origin_beside(in / "g.ply") == Vec3{448'000, 4'511'000, 0});
  CHECK(read_mesh(in / "g.ply").vertices.bounds().max.x > 448'000.0);
  std::filesystem::rename(in / "g.ply", in / "alone.ply");
  CHECK(read_mesh(in / "alone.ply").vertices.bounds().max.x < 20.0);
  CHECK(run_in(in, {"convert", "t.ply", "f.ply", "--origin", "1,2"}).status == 2);
  CHECK(run_in(in, {"convert", "t.ply", "f.ply", "--origin", "middle"}).status == 2);
}

TEST_CASE("TilesShareTheOriginOfTheMesh") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  REQUIRE(reconstruct(in, {"t.las"}, "m.ply",
                      {"--tiles", "--precision", "float", "--chunk-points", "200"})
              .status == 0);
  const Json index = Json::parse(file_text(in / "m.tiles/tiles.json"));
  CHECK(index["origin"][1] == 4'511'006.0);
  CHECK(index["bounds"][0][0].get<double>() > 447'000.0);
  REQUIRE(index["tiles"].size() > 1);
  for (const Json& tile : index["tiles"]) {
    const TriangleMesh mesh = read_mesh(in / ("m.tiles/" + tile["file"].get<std::string>()));
    CHECK(mesh.vertices.bounds().max.x < 20.0);
    CHECK(mesh.vertices.schema.attributes[8].type == ScalarType::kUint8);
  }
  CHECK(origin_beside(in / "m.ply").x == 448'006.0);
}

TEST_CASE("WideColorsComeOutAsOtherProgramsShowThem") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  write_tile(in / "dim.las", {.brightest = 255});
  const auto brightest = [&](const std::string& mesh) {
    const PointCloud cloud = read_mesh(in / mesh).vertices;
    const std::vector<std::string> names = names_of(cloud.schema);
    const auto red = static_cast<std::size_t>(std::ranges::find(names, "red") - names.begin());
    REQUIRE(red < names.size());
    double most = 0.0;
    for (std::size_t i = 0; i < cloud.size(); ++i)
      most = std::max(most, attribute_value(cloud, i, red));
    return std::pair(most, cloud.schema.attributes[red].type);
  };
  for (const char* scan : {"t.las", "dim.las"})
    for (const char* mesh : {"m.ply", "m.obj"}) {
      CAPTURE(scan, mesh);
      REQUIRE(reconstruct(in, {scan}, mesh).status == 0);
      CHECK(brightest(mesh) == std::pair(255.0, ScalarType::kUint8));
    }
  REQUIRE(reconstruct(in, {"t.las"}, "w.ply", {"--colors", "16"}).status == 0);
  CHECK(brightest("w.ply") == std::pair(65'535.0, ScalarType::kUint16));
  CHECK(reconstruct(in, {"t.las"}, "x.ply", {"--colors", "12"}).status == 2);
  for (const char* scan : {"t.las", "dim.las"}) {
    REQUIRE(run_in(in, {"convert", scan, "c.ply"}).status == 0);
    CHECK(brightest("c.ply") == std::pair(255.0, ScalarType::kUint8));
  }
  REQUIRE(run_in(in, {"convert", "t.las", "c16.ply", "--colors", "16"}).status == 0);
  CHECK(brightest("c16.ply") == std::pair(65'535.0, ScalarType::kUint16));
}

TEST_CASE("OneDimScanAmongBrightOnesIsScaledLikeThem") {
  const ScratchDirectory in;
  write_tile(in / "dim.las", {.brightest = 255});
  write_tile(in / "t.las", {.place = {448'012.0, 4'511'000.0, 1300.0}});
  Arguments chunks = {"--chunk-points", "100"};
  REQUIRE(reconstruct(in, {"dim.las", "t.las"}, "a.ply").status == 0);
  REQUIRE(reconstruct(in, {"t.las", "dim.las"}, "b.ply", chunks).status == 0);
  CHECK(file_text(in / "a.ply") == file_text(in / "b.ply"));
}

TEST_CASE("AttributesOfOneScanAreKeptBesideOnesThatLackThem") {
  const ScratchDirectory in;
  write_tile(in / "time.las", {.format = 1});
  write_tile(in / "color.las", {.format = 2, .place = {448'012.0, 4'511'000.0, 1300.0}});
  REQUIRE(reconstruct(in, {"time.las", "color.las"}, "a.ply", {"--report", "r.json"}).status == 0);
  const std::vector<std::string> names = names_of(read_mesh(in / "a.ply").vertices.schema);
  for (const char* name : {"gps_time", "red", "green", "blue", "classification", "intensity"})
    CHECK(std::ranges::find(names, name) != names.end());
  CHECK_THAT(report_of(in)["notes"].dump(),
             Contains("attribute gps_time (float64) is 0 at points of color.las, which lacks it"));
  REQUIRE(reconstruct(in, {"color.las", "time.las"}, "b.ply", {"--chunk-points", "100"}).status ==
          0);
  CHECK(file_text(in / "a.ply") == file_text(in / "b.ply"));
}

TEST_CASE("WhatAFormatHasNoPlaceForIsSaid") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  REQUIRE(reconstruct(in, {"t.las"}, "m.obj", {"--report", "r.json"}).status == 0);
  CHECK_THAT(report_of(in)["notes"].dump(),
             Contains("m.obj has no place for intensity, return_number, number_of_returns, "
                      "classification"));
  REQUIRE(reconstruct(in, {"t.las"}, "m.stl", {"--report", "r.json"}).status == 0);
  CHECK_THAT(report_of(in)["notes"].dump(),
             Contains("m.stl has no place for normals, intensity") && Contains("red, green, blue"));
  REQUIRE(reconstruct(in, {"t.las"}, "m.ply", {"--report", "r.json"}).status == 0);
  CHECK_THAT(report_of(in)["notes"].dump(), !Contains("no place for"));
}

TEST_CASE("OriginColorsAndAttributesAreTheSameBytesForAnyPartitionAndOrder") {
  const ScratchDirectory in;
  write_tile(in / "a.las", {.brightest = 255});
  write_tile(in / "b.las", {.format = 3, .place = {448'012.0, 4'511'000.0, 1300.0}});
  write_tile(in / "c.las", {.format = 1, .place = {448'000.0, 4'511'012.0, 1300.0}});
  const std::string mesh = GENERATE("m.stl", "m.obj", "m.ply");
  const Arguments precision = {"--precision", "float"};
  REQUIRE(reconstruct(in, {"a.las", "b.las", "c.las"}, mesh, precision).status == 0);
  const std::string expected = file_text(in / mesh);
  const std::string shift = file_text(in / (mesh + ".shift.txt"));
  for (const char* chunk_points : {"150", "100000"})
    for (const char* threads : {"1", "2"}) {
      CAPTURE(mesh, chunk_points, threads);
      Arguments more = precision;
      more.insert(more.end(), {"--chunk-points", chunk_points, "--threads", threads});
      REQUIRE(reconstruct(in, {"c.las", "a.las", "b.las"}, mesh, more).status == 0);
      CHECK((file_text(in / mesh) == expected));
      CHECK(file_text(in / (mesh + ".shift.txt")) == shift);
    }
}

TEST_CASE("ASystemBesideTheOutputThatIsNotItsOwnIsWarnedOf") {
  const ScratchDirectory in;
  write_text(in / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  const std::vector<Arguments> commands = {
      {"convert", "a.obj", "b.ply"},
      {"fill", "a.obj", "-o", "b.ply", "--progress", "none"},
      {"simplify", "a.obj", "-o", "b.ply", "--ratio", "1", "--progress", "none"}};
  for (const Arguments& command : commands) {
    CHECK(run_in(in, command).err.empty());
    write_text(in / "b.prj", "EPSG:32632\n");
    const ProgramResult result = run_in(in, command);
    CHECK(result.status == 0);
    CHECK_THAT(result.err, Contains("b.prj was there before") && Contains("a.obj tells of none"));
    CHECK(file_text(in / "b.prj") == "EPSG:32632\n");
    std::filesystem::remove(in / "b.prj");
  }
}

TEST_CASE("DistancesBetweenCoordinatesOfTwoSystemsAreWarnedOf") {
  const ScratchDirectory in;
  write_tile(in / "a.las");
  write_tile(in / "b.las", {.epsg = 26913});
  REQUIRE(reconstruct(in, {"a.las"}, "m.ply").status == 0);
  for (const Arguments& command : std::vector<Arguments>{
           {"compare", "m.ply"}, {"compare", "a.las"}, {"inspect", "m.ply", "--against"}}) {
    Arguments one = command;
    one.emplace_back("a.las");
    CHECK(run_in(in, one).err.empty());
    one.back() = "b.las";
    const ProgramResult result = run_in(in, one);
    CHECK(result.status == 0);
    CHECK_THAT(result.err, Contains("b.las: its coordinates are of another system than those of " +
                                    command[1]) &&
                               Contains("found NAD83 / UTM zone 13N, EPSG:26913") &&
                               Contains("expected NAD83 / UTM zone 12N, EPSG:26912"));
  }
}

TEST_CASE("EightBitColoursInWideFieldsBesideWideColoursAreNoted") {
  const ScratchDirectory in;
  write_tile(in / "wide.las");
  write_tile(in / "dark.las", {.place = {448'012.0, 4'511'000.0, 1300.0}, .brightest = 255});
  write_tile(in / "other.las", {.place = {448'012.0, 4'511'000.0, 1300.0}, .brightest = 65'535});
  const std::string note = "dark.las has colours up to 255 at the first points";
  const ProgramResult mixed = reconstruct(in, {"wide.las", "dark.las"}, "m.ply", {});
  CHECK(mixed.status == 0);
  CHECK_THAT(mixed.err, Contains(note) && Contains("orbweave convert dark.las dark-8bit.ply"));
  CHECK_THAT(reconstruct(in, {"dark.las", "wide.las"}, "n.ply", {}).err, Contains(note));
  CHECK((file_text(in / "m.ply") == file_text(in / "n.ply")));
  CHECK_THAT(reconstruct(in, {"wide.las", "other.las"}, "m.ply", {}).err,
             !Contains("colours up to"));
  CHECK_THAT(reconstruct(in, {"dark.las"}, "m.ply", {}).err, !Contains("colours up to"));
  // What the note says does what is meant.
  REQUIRE(run_in(in, {"convert", "dark.las", "dark-8bit.ply"}).status == 0);
  const ProgramResult mended = reconstruct(in, {"wide.las", "dark-8bit.ply"}, "m.ply", {});
  CHECK(mended.status == 0);
  CHECK_THAT(mended.err, !Contains("colours up to"));
}

TEST_CASE("AnEmptyMeshIsOneInEveryFormat") {
  const ScratchDirectory in;
  write_text(in / "a.stl", "solid a\nendsolid a\n");
  for (const char* name : {"b.obj", "c.glb", "d.stl", "e.obj"}) {
    INFO(name);
    CHECK(run_in(in, {"convert", "a.stl", name}).status == 0);
    CHECK_THAT(run_in(in, {"inspect", name}).out,
               Contains("kind                  mesh") && Contains("vertices              0"));
  }
  write_text(in / "scene.obj",
             "# of a scene without meshes\nmtllib scene.mtl\no Empty\nvn 0 0 1\n");
  CHECK(run_in(in, {"convert", "scene.obj", "f.obj"}).status == 0);
  write_text(in / "words.obj", "# no OBJ file\nsolid a\nendsolid a\n");
  const ProgramResult refused = run_in(in, {"inspect", "words.obj"});
  CHECK(refused.status == 3);
  CHECK_THAT(refused.err,
             Contains("words.obj: line 2: the OBJ file has no vertices; found \"solid\""));
}

TEST_CASE("VerticesThatAFileOfFacetsHasNoPlaceForAreNamed") {
  const ScratchDirectory in;
  write_text(in / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 2\nf 1 2 3\n");
  CHECK_THAT(run_in(in, {"convert", "a.obj", "b.stl"}).out,
             Contains("left out: 2 vertices without a triangle: the format has no place for them"));
  CHECK_THAT(run_in(in, {"convert", "a.obj", "b.ply"}).out, !Contains("left out"));
}

TEST_CASE("FilesBesideACloudHideNothingThatTheCloudTells") {
  const ScratchDirectory in;
  write_tile(in / "a.las", {.epsg = 0});
  write_text(in / "a.prj", "EPSG:26912\n");
  const FileFacts las = open_point_source(in / "a.las")->facts();
  CHECK(las.format == "LAS");
  CHECK(las.point_format == 2);
  CHECK_THAT(run_in(in, {"inspect", "a.las"}).out,
             Contains("format       LAS 1.2, point format 2") && Contains("EPSG:26912"));

  write_text(in / "b.ptx",
             "1\n2\n1 2 3\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1 2 3 1\n"
             "1 0 0 0.5\n2 0 0 0.5\n");
  write_text(in / "b.ptx.shift.txt", "b.ptx; -100; -200; 0; 1;\n");
  const auto ptx = open_point_source(in / "b.ptx");
  CHECK(read_all(*ptx).positions == std::vector<Vec3>{{102, 202, 3}, {103, 202, 3}});
  REQUIRE(ptx->facts().scans.size() == 1);
  CHECK(ptx->facts().format == "PTX");
  CHECK(ptx->facts().scans[0].pose->translation == Vec3{101, 202, 3});
  CHECK(ptx->facts().scans[0].scanner == ScannerPlace{{101, 202, 3}});
}

TEST_CASE("ACropPassesOverAWholeFileWithItsShiftByBoundsInTheWorld") {
  const ScratchDirectory in;
  LasFile file{.minor = 2, .format = 0};
  file.scale = {1, 1, 1};
  for (const std::int32_t corner : {0, 10}) {
    LasPoint point;
    point.xyz = {corner, corner, corner};
    file.add(point);
  }
  constexpr std::size_t kBoundsInHeader = 179;  // largest and least x, y and z
  std::string bytes = file.bytes();
  bytes.replace(kBoundsInHeader, 48, raw(10.) + raw(0.) + raw(10.) + raw(0.) + raw(10.) + raw(0.));
  std::ofstream(in / "a.las", std::ios::binary) << bytes;
  write_text(in / "a.las.shift.txt", "a.las; -1000; 0; 0; 1;\n");
  const Box whole{{1000, 0, 0}, {1010, 10, 10}};
  const auto source = open_point_source(in / "a.las");
  CHECK(source->facts().declared_bounds == whole);
  Box seen;
  source->skip_parts([&](const Box& part) {
    seen.extend(part);
    return true;
  });
  CHECK(read_all(*source).empty());
  CHECK(seen == whole);
  CHECK(source->left_out() == DroppedPoints{{kOutsideCrop, 2}});
}

TEST_CASE("ConvertAndInspectTakeTheNamesOfColumns") {
  const ScratchDirectory in;
  write_text(in / "a.csv", "Easting,Northing,Height,Code\n1,2,3,300\n4,5,6,7\n");
  const ProgramResult unnamed = run_in(in, {"convert", "a.csv", "b.csv"});
  CHECK(unnamed.status == 3);
  CHECK_THAT(unnamed.err, Contains("Name them with input.columns (--columns)"));
  const Arguments names = {"--columns", "x,y,z,code:uint16"};
  REQUIRE(run_in(in, {"convert", "a.csv", "b.ply", names[0], names[1]}).status == 0);
  const PointCloud cloud = read_all(*open_point_source(in / "b.ply"));
  CHECK(cloud.positions == std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}});
  CHECK(cloud.schema.attributes == std::vector<AttributeField>{{"code", ScalarType::kUint16}});
  const Json facts =
      Json::parse(run_in(in, {"inspect", "a.csv", names[0], names[1], "--json"}).out);
  CHECK(facts["attributes"][0]["name"] == "code");
  CHECK(facts["attributes"][0]["max"] == 300.0);
  const ProgramResult few = run_in(in, {"convert", "a.csv", "b.ply", "--columns", "x,y,z"});
  CHECK(few.status == 3);
  CHECK_THAT(few.err, Contains("a.csv: line 2: the line has another number of columns than are "
                               "named; found 4 columns, expected 3"));
  write_text(in / "c.txt", "1,2 3,4 5,6\n");
  CHECK(run_in(in, {"convert", "c.txt", "d.ply", "--separator", "blank"}).status == 3);
}

TEST_CASE("WholeNumbersThatADoubleRoundsAreWarnedOf") {
  const ScratchDirectory in;
  write_text(in / "a.csv",
             "x,y,z,stamp,hash,id\n"
             "1,2,3,1700000000123456789,18446744073709551615,9007199254740992\n");
  const ProgramResult rounded = run_in(in, {"convert", "a.csv", "b.csv"});
  CHECK(rounded.status == 0);
  CHECK_THAT(rounded.err, Contains("a.csv: not carried over: the last digits of column stamp,") &&
                              Contains("stamp:int64") && Contains("hash:uint64") &&
                              !Contains("column id"));
  CHECK_THAT(run_in(in, {"inspect", "a.csv"}).out,
             Contains("not read") && Contains("the last digits of column stamp,"));
  const std::string columns = "x,y,z,stamp:int64,hash:uint64,id";
  const ProgramResult named = run_in(in, {"convert", "a.csv", "b.csv", "--columns", columns});
  CHECK(named.err.empty());
  CHECK(file_text(in / "b.csv") == file_text(in / "a.csv"));
  CHECK_THAT(run_in(in, {"inspect", "a.csv", "--columns", columns}).out, !Contains("not read"));
}

TEST_CASE("AJobSaysWhichValuesOfItsScansNoMeshGets") {
  const ScratchDirectory in;
  std::string csv = "x,y,z,stamp\n", ply;
  for (int i = 0; i < 100; ++i) {
    const std::string place = std::to_string(i % 10) + "," + std::to_string(i / 10) + ",0,";
    csv += place + std::to_string(1'700'000'000'000'000'001 + i) + "\n";
    ply += std::to_string(20 + i % 10) + " " + std::to_string(i / 10) + " 0 1 7\n";
  }
  write_text(in / "a.csv", csv);
  write_text(in / "b.csv", csv);
  write_text(in / "c.ply",
             "ply\nformat ascii 1.0\nelement vertex 100\nproperty double x\nproperty double y\n"
             "property double z\nproperty list uchar int tags\nend_header\n" +
                 ply);
  REQUIRE(reconstruct(in, {"a.csv", "b.csv", "c.ply"}, "m.ply", {"--report", "r.json"}).status ==
          0);
  CHECK_THAT(report_of(in)["notes"].dump(),
             Contains("a.csv and 1 more: not carried over: the last digits of column stamp,") &&
                 Contains("c.ply: not carried over: vertex list tags"));
  // Whoever wants no attributes loses none.
  REQUIRE(reconstruct(in, {"a.csv", "c.ply"}, "n.ply", {"--report", "r.json", "--no-attributes"})
              .status == 0);
  CHECK_THAT(report_of(in)["notes"].dump(), !Contains("not carried over"));
}

TEST_CASE("WhatAFileHoldsAndNoMeshTakesIsNamed") {
  const ScratchDirectory in;
  const std::string corners = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const std::string front =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\n";
  const std::string faces = "property list uchar int vertex_indices\n";
  write_text(in / "a.ply",
             front + "element edge 1\nproperty int vertex1\nelement face 3\n" + faces +
                 "property uchar red\nproperty float quality\nproperty int hole\n"
                 "property float confidence\nend_header\n" +
                 corners + "7\n3 0 1 2 9 0.5 0 1\n2 0 1 9 0.5 0 1\n3 0 2 3 9 0.5 0 1\n");
  const std::string named =
      "a.ply: not carried over: element edge of 1 row; face properties red, quality";
  for (const Arguments& command :
       std::vector<Arguments>{{"convert", "a.ply", "b.ply"},
                              {"fill", "a.ply", "-o", "b.ply", "--progress", "plain"}}) {
    const ProgramResult result = run_in(in, command);
    CHECK(result.status == 0);
    CHECK_THAT(result.err, Contains(named + "; 1 face with fewer than three corners\n"));
    CHECK(run_in(in, {"convert", "b.ply", "c.ply"}).err.empty());
  }
  const Json listed = Json::parse(run_in(in, {"inspect", "a.ply", "--json"}).out);
  CHECK(listed["not_read"] == Json({"element edge of 1 row", "face properties red, quality",
                                    "1 face with fewer than three corners"}));
  CHECK_THAT(run_in(in, {"inspect", "a.ply"}).out, Contains("element edge of 1 row\n"));
  CHECK_THAT(run_in(in, {"simplify", "a.ply", "-o", "s.ply", "--ratio", "1"}).err,
             Contains(named + "\n"));

  write_text(in / "cloud.ply", front + "property list uchar int tags\nelement range_grid 1\n" +
                                   faces +
                                   "end_header\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n3 0 1 2\n");
  CHECK_THAT(run_in(in, {"convert", "cloud.ply", "b.ply"}).err,
             Contains("not carried over: vertex list tags; element range_grid of 1 row\n"));

  write_text(in / "m.obj",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 9 9 9 1 0 0\nvt 0 0\nvn 0 0 1\nusemtl a\n"
             "f 1/1/1 2/1/1 3/1/1\nl 1 2\n");
  CHECK_THAT(run_in(in, {"convert", "m.obj", "b.ply"}).err,
             Contains("m.obj: not carried over: texture coordinates; materials; lines; colours, "
                      "which not all vertices have; normals, which not all vertices have\n"));
}

TEST_CASE("AFormatWithoutAPlaceForTheHolesOfFacesIsNamed") {
  const ScratchDirectory in;
  const auto write = [&](const std::string& hole) {
    write_text(
        in / "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
        "property int hole\nproperty float confidence\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n"
        "3 0 1 2 0 1\n3 2 1 3 " +
            hole + " 0.25\n");
  };
  write("5");
  for (const char* name : {"b.obj", "b.stl", "b.glb"})
    CHECK_THAT(
        run_in(in, {"convert", "a.ply", name}).out,
        Contains("left out: hole (of faces), confidence (of faces): the format has no place"));
  CHECK_THAT(run_in(in, {"convert", "a.ply", "b.vtp"}).out,
             Contains("left out: confidence (of faces): "));
  CHECK_THAT(run_in(in, {"convert", "a.ply", "b.ply"}).out, !Contains("left out"));
  write("0");
  CHECK_THAT(run_in(in, {"convert", "a.ply", "b.obj"}).out, !Contains("left out"));
  // Of a mesh with a hole that is filled.
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "3000", "-o", "c.ply"}).status == 0);
  const Arguments pierced = {"--report", "r.json", "--crop", "-2,-2,-2,2,2,0.97",
                             "--close-outer-border"};
  REQUIRE(reconstruct(in, {"c.ply"}, "m.obj", pierced).status == 0);
  REQUIRE_FALSE(report_of(in)["holes"].empty());
  CHECK_THAT(report_of(in)["notes"].dump(), Contains("m.obj has no place for hole (of faces)"));
  REQUIRE(reconstruct(in, {"c.ply"}, "m.ply", pierced).status == 0);
  CHECK_THAT(report_of(in)["notes"].dump(), !Contains("no place"));
}

TEST_CASE("TriangleStripsAreTriangles") {
  const ScratchDirectory in;
  const std::string front =
      "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
      "property float z\n";
  const std::string list = "property list int int vertex_indices\n";
  const std::string corners = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n1 2 0\n";
  // Two strips in one row; a vertex that is named twice leads on without a triangle.
  write_text(in / "strips.ply", front + "element tristrips 1\n" + list + "end_header\n" + corners +
                                    "11 0 1 2 3 4 4 -1 5 4 3 -1\n");
  const TriangleMesh strips = read_mesh(in / "strips.ply");
  CHECK(strips.triangles ==
        std::vector<orbweave::Triangle>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {5, 4, 3}});
  // Beside faces, of which some fill a hole.
  write_text(in / "both.ply", front + "element tristrips 1\n" + list + "element face 1\n" + list +
                                  "property int hole\nend_header\n" + corners +
                                  "4 0 1 2 3\n3 2 3 4 7\n");
  const TriangleMesh both = read_mesh(in / "both.ply");
  CHECK(both.triangles == std::vector<orbweave::Triangle>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}});
  CHECK(both.hole == std::vector<std::int32_t>{0, 0, 7});
  for (const char* name : {"strips.ply", "both.ply"}) {
    const ProgramResult inspected = run_in(in, {"inspect", name});
    CHECK_THAT(inspected.out, Contains("mesh") && !Contains("not read"));
    const ProgramResult converted = run_in(in, {"convert", name, "out.ply"});
    CHECK(converted.err.empty());
    CHECK(read_mesh(in / "out.ply").triangles == read_mesh(in / name).triangles);
    CHECK(run_in(in, {"simplify", name, "-o", "s.ply", "--ratio", "1"}).status == 0);
  }
  const ProgramResult streamed = run_limited(in, "exec < strips.ply", {"convert", "-", "out.ply"});
  CHECK_THAT(streamed.err, Contains("a mesh is not converted from a stream; found 1 row of "
                                    "triangle strips"));
  write_text(in / "bad.ply",
             front + "element tristrips 1\n" + list + "end_header\n" + corners + "4 0 1 2 6\n");
  CHECK_THAT(run_in(in, {"convert", "bad.ply", "out.ply"}).err,
             Contains("bad.ply: element tristrips: a triangle strip names a vertex that is not "
                      "there; found vertex 6, expected 0 to 6 (excluded), or -1"));
}

TEST_CASE("TheIdOfAHoleIsNeverCutShort") {
  const ScratchDirectory in;
  const auto write = [&](const std::string& type, const std::string& id) {
    write_text(
        in / "a.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nproperty " +
            type + " hole\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 " + id + "\n");
  };
  for (const auto& [type, id] : {std::pair("int64", "4294967297"), std::pair("uint", "2147483648"),
                                 std::pair("uint64", "18446744073709551615")}) {
    write(type, id);
    for (const Arguments& command : std::vector<Arguments>{
             {"convert", "a.ply", "b.ply"}, {"simplify", "a.ply", "-o", "b.ply", "--ratio", "1"}}) {
      const ProgramResult result = run_in(in, command);
      CHECK(result.status == 3);
      CHECK_THAT(result.err,
                 Contains("a.ply: face 0: the id of a hole does not fit 32 bits; found " +
                          std::string(id)));
    }
  }
  write("uint64", "2147483647");
  CHECK(run_in(in, {"convert", "a.ply", "b.ply"}).status == 0);
  CHECK(read_mesh(in / "b.ply").hole == std::vector<std::int32_t>{2'147'483'647});
}

TEST_CASE("APlyFileWithoutItsShiftIsWarnedOf") {
  const ScratchDirectory in;
  write_text(in / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  REQUIRE(run_in(in, {"convert", "a.obj", "b.ply", "--origin", "100,200,0"}).status == 0);
  CHECK(run_in(in, {"inspect", "b.ply"}).err.empty());
  std::filesystem::rename(in / "b.ply", in / "c.ply");
  for (const Arguments& command : std::vector<Arguments>{
           {"inspect", "c.ply"}, {"compare", "a.obj", "c.ply"}, {"convert", "c.ply", "d.obj"}}) {
    const ProgramResult result = run_in(in, command);
    CHECK(result.status == 0);
    CHECK_THAT(result.err,
               Contains("counted from 100 200 0") && Contains("c.ply.shift.txt is not beside it"));
  }
  std::filesystem::rename(in / "b.ply.shift.txt", in / "c.ply.shift.txt");
  const ProgramResult whole = run_in(in, {"compare", "a.obj", "c.ply"});
  CHECK(whole.err.empty());
  CHECK_THAT(whole.out, Contains("same: "));
}

TEST_CASE("CompareTakesCloudsOfEveryFormat") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  write_text(in / "b.csv", "x,y,z\n0,1,0\n0,0,0\n1,0,0\n");
  const ProgramResult result = run_in(in, {"compare", "a.xyz", "b.csv"});
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  CHECK_THAT(result.out, StartsWith("same surface"));
  write_text(in / "c.xyz", "0 0 0\n1 0 0\n0 1 0.5\n");
  CHECK_THAT(run_in(in, {"compare", "a.xyz", "c.xyz"}).out,
             StartsWith("different") && Matches("(.|\n)*\nchecksum +- +-\n(.|\n)*"));
}

TEST_CASE("WhatReplacesAFileWithAnOriginHasNone") {
  const ScratchDirectory in;
  write_text(in / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  write_text(in / "a.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  const std::vector<Arguments> commands = {
      {"compare", "a.obj", "a.obj", "--errors", "b.ply"},
      {"inspect", "a.obj", "--against", "a.xyz", "--errors", "b.ply"},
      {"generate", "sphere", "--points", "500", "-o", "b.ply"},
      {"generate", "sphere", "--points", "500", "-o", "c.ply", "--truth", "b.ply"}};
  for (const Arguments& command : commands) {
    REQUIRE(run_in(in, {"convert", "a.obj", "b.ply", "--origin", "100,200,0"}).status == 0);
    CHECK(origin_beside(in / "b.ply") == Vec3{100, 200, 0});
    CHECK(run_in(in, command).status == 0);
    CHECK(origin_beside(in / "b.ply") == Vec3{});
  }
}

TEST_CASE("PolygonsAndMedialAxisOfAnOriginAreReadWhereTheMeshIs") {
  if (!has_voronoi_family()) {
    std::cout << "SKIPPED: built without the Voronoi family\n";
    return;
  }
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "600", "-o", "s.ply"}).status == 0);
  REQUIRE(run_in(in, {"reconstruct", "s.ply", "--method", "power_crust", "-o", "m.ply",
                      "--polygons", "p.obj", "--medial-axis", "a.ply", "--origin", "100,0,0"})
              .status == 0);
  for (const char* file : {"p.obj", "a.ply"}) {
    const Box bounds = read_all(*open_point_source(in / file)).bounds();
    CHECK(bounds.min.x > -1.1);
    CHECK(bounds.max.x < 1.1);
  }
}

TEST_CASE("WhatAFormatOfMeshesDoesNotHoldIsSaid") {
  const ScratchDirectory in;
  TriangleMesh mesh;
  mesh.vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.vertices.schema.attributes = {{"intensity", ScalarType::kUint8}};
  mesh.vertices.attributes.resize(4);
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}};
  write_mesh(in / "a.ply", mesh);
  for (const std::string out : {"b.stl", "b.obj", "b.ply"}) {
    for (const Arguments& command : std::vector<Arguments>{
             {"convert", "a.ply", out},
             {"fill", "a.ply", "-o", out, "--progress", "none"},
             {"simplify", "a.ply", "-o", out, "--ratio", "1", "--progress", "none"}}) {
      const ProgramResult result = run_in(in, command);
      CHECK(result.status == 0);
      CHECK(result.err.empty());
      CHECK((result.out.find("intensity: the format has no place") != std::string::npos) ==
            (out != "b.ply"));
    }
  }
}
