// Where a surveyor's files lie: coordinate systems, units, and origins that coordinates count from.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/pipeline/surface/in_core_methods.h"
#include "io/clouds/open_point_source.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/shift_file.h"
#include "io/points/coordinate_system.h"
#include "io/points/coordinate_system_file.h"
#include "tests/cli/survey_tiles.h"
#include "tests/io/las_files.h"
#include "tests/io/reading.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;
using Json = nlohmann::json;

namespace {

using Arguments = std::vector<std::string>;

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

TEST_CASE("TheSystemThatAJobWritesBesideItsScanIsNoChangeOfTheScan") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  const Arguments keeps = {"--keep-work-dir"};
  REQUIRE(reconstruct(in, {"t.las"}, "t.ply", keeps).status == 0);
  REQUIRE(std::filesystem::exists(in / "t.prj"));
  const ProgramResult again = reconstruct(in, {"t.las"}, "t.ply", keeps);
  CHECK(again.status == 0);
  CHECK_THAT(again.err, !Contains("computed again") && !Contains("count: begins"));
  CHECK_THAT(reconstruct(in, {"t.las"}, "t.ply").out, Contains("as an earlier run of this job"));
}

TEST_CASE("ASystemThatComesToLieBesideAScanIsAChange") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  REQUIRE(run_in(in, {"convert", "t.las", "cloud.ply"}).status == 0);
  const std::string system = file_text(in / "cloud.prj");
  std::filesystem::remove(in / "cloud.prj");
  REQUIRE(reconstruct(in, {"cloud.ply"}, "mesh.ply", {"--keep-work-dir"}).status == 0);
  CHECK_FALSE(std::filesystem::exists(in / "mesh.prj"));
  write_text(in / "cloud.prj", system);
  REQUIRE(reconstruct(in, {"cloud.ply"}, "mesh.ply").status == 0);
  CHECK(file_text(in / "mesh.prj") == system);
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
    const auto file = in / ("m.tiles/" + tile["file"].get<std::string>());
    std::filesystem::copy_file(file, in / "alone.ply",
                               std::filesystem::copy_options::overwrite_existing);
    CHECK(read_mesh(in / "alone.ply").vertices.bounds().max.x < 20.0);
    // Among the others of its mesh it is where it lies in the world.
    const TriangleMesh mesh = read_mesh(file);
    CHECK(std::abs(mesh.vertices.bounds().max.x - tile["bounds"][1][0].get<double>()) < 1e-6);
    CHECK(coordinate_system_beside(file) == coordinate_system_beside(in / "m.ply"));
    CHECK(mesh.vertices.schema.attributes[8].type == ScalarType::kUint8);
  }
  CHECK(origin_beside(in / "m.ply").x == 448'006.0);
  CHECK_FALSE(coordinate_system_beside(in / "m.ply").empty());
  CHECK(coordinate_system_beside(in / "alone.ply").empty());
}

TEST_CASE("TheSummaryNamesWhatLiesBesideASimplifiedMesh") {
  const ScratchDirectory in;
  write_tile(in / "t.las");
  const ProgramResult run =
      reconstruct(in, {"t.las"}, "m.ply", {"--simplify", "ratio=0.5", "--simplified", "small.stl"});
  REQUIRE(run.status == 0);
  CHECK(std::filesystem::exists(in / "small.stl.shift.txt"));
  CHECK_THAT(run.out, Contains("small.prj\n") && Contains("small.stl.shift.txt\n") &&
                          !Contains("m.ply.shift.txt"));
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

TEST_CASE("ACompressedFileHasWhatLiesBesideItWithoutCompression") {
  const ScratchDirectory in;
  write_text(in / "scan.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  write_text(in / "scan.prj", "EPSG:32632\n");
  gzip_file(in / "scan.xyz.gz", file_text(in / "scan.xyz"));
  CHECK_THAT(run_in(in, {"inspect", "scan.xyz.gz"}).out, Contains("EPSG:32632"));
  for (const char* name : {"a.ply", "b.ply.gz", "C.XYZ.GZ"}) {
    const ProgramResult result = run_in(in, {"convert", "scan.xyz.gz", name});
    CHECK(result.status == 0);
    CHECK(result.err.empty());
    CHECK_THAT(run_in(in, {"inspect", name}).out, Contains("UTM zone 32N"));
  }
  CHECK(names_in(in) == Arguments{"C.XYZ.GZ", "C.prj", "a.ply", "a.prj", "b.ply.gz", "b.prj",
                                  "scan.prj", "scan.xyz", "scan.xyz.gz"});

  REQUIRE(run_in(in, {"convert", "scan.xyz", "o.ply.gz", "--origin", "100,200,0"}).status == 0);
  std::filesystem::remove(in / "o.ply.gz.shift.txt");
  CHECK_THAT(run_in(in, {"inspect", "o.ply.gz"}).err,
             Contains("counted from 100 200 0") && Contains("o.ply.gz.shift.txt is not beside it"));
}

TEST_CASE("AShiftThatCannotBeReadIsNotPassedOver") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  const int listening = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  const std::string name = (in / "a.xyz.shift.txt").string();
  REQUIRE(name.size() < sizeof address.sun_path);
  name.copy(address.sun_path, name.size());
  REQUIRE(::bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  const ProgramResult result = run_in(in, {"inspect", "a.xyz"});
  ::close(listening);
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("a.xyz.shift.txt: cannot open the shift"));
}

TEST_CASE("TheShiftsOfAFolderAreNoClouds") {
  const ScratchDirectory in;
  std::filesystem::create_directory(in / "all");
  write_text(in / "all" / "a.obj",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n");
  write_text(in / "all" / "c.shift.txt", "1 2 3\n4 5 6\n");  // of no file: a cloud
  for (const char* name : {"all/b.stl", "all/d.ply.gz"})
    REQUIRE(run_in(in, {"convert", "all/a.obj", name, "--origin", "5,5,5"}).status == 0);
  const ProgramResult result = run_in(in, {"inspect", "all", "--json"});
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  Arguments listed;
  for (const Json& file : Json::parse(result.out)) listed.push_back(file["file"]);
  CHECK(listed == Arguments{"all/a.obj", "all/b.stl", "all/c.shift.txt", "all/d.ply.gz"});
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
