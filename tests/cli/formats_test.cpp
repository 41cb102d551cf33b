// What a surveyor's files come out as: colours, attributes, and what a format has no place for.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/clouds/open_point_source.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "tests/cli/survey_tiles.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using Catch::Matchers::Matches;
using Catch::Matchers::StartsWith;
using namespace orbweave;
using namespace orbweave::test;
using Json = nlohmann::json;

namespace {

using Arguments = std::vector<std::string>;

std::vector<std::string> names_of(const PointSchema& schema) {
  std::vector<std::string> names;
  for (const AttributeField& field : schema.attributes) names.push_back(field.name);
  return names;
}

}  // namespace

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

TEST_CASE("OneScanWithoutNormalsHasThoseOfAllEstimatedInAnyOrder") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "2000", "-o", "with.ply"}).status == 0);
  write_tile(in / "tile.las", {.place = {0.0, 0.0, 0.0}});
  REQUIRE(run_in(in, {"convert", "tile.las", "without.ply"}).status == 0);
  const std::string note =
      "the normals of with.ply are not taken, since without.ply has none: normals of all points "
      "are estimated";
  for (const Arguments& scans :
       {Arguments{"with.ply", "without.ply"}, Arguments{"without.ply", "with.ply"}}) {
    CAPTURE(scans[0]);
    const std::string mesh = scans[0] + "-first.ply";
    REQUIRE(reconstruct(in, scans, mesh, {"--report", "r.json"}).status == 0);
    CHECK_THAT(report_of(in)["notes"].dump(), Contains(note));
  }
  CHECK(file_text(in / "with.ply-first.ply") == file_text(in / "without.ply-first.ply"));
  REQUIRE(reconstruct(in, {"with.ply", "without.ply"}, "m.ply",
                      {"--normals", "estimate", "--report", "r.json"})
              .status == 0);
  CHECK_THAT(report_of(in)["notes"].dump(), !Contains("normals of with.ply"));
  const auto refused = reconstruct(in, {"with.ply", "without.ply"}, "m.ply", {"--normals", "file"});
  CHECK(refused.status == 3);
  CHECK_THAT(refused.err, Contains("without.ply: some files have normals and some have none") &&
                              Contains("--normals estimate"));
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

TEST_CASE("ConvertAndInspectTakeTheNamesOfColumns") {
  const ScratchDirectory in;
  write_text(in / "a.csv", "Rechtswert,Hochwert,Hoehe,Code\n1,2,3,300\n4,5,6,7\n");
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

TEST_CASE("FacesThatNameNoVerticesAreLeftOutOfACloud") {
  const ScratchDirectory in;
  write_text(in / "a.ply",
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
             "property float z\nelement face 1\nproperty list uchar int corners\nend_header\n"
             "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  const std::string named = "element face of 1 row without a list vertex_indices\n";
  const ProgramResult converted = run_in(in, {"convert", "a.ply", "b.ply"});
  CHECK(converted.status == 0);
  CHECK(converted.out == "b.ply: 3 points\n");
  CHECK_THAT(converted.err, Contains("a.ply: not carried over: " + named));
  const ProgramResult inspected = run_in(in, {"inspect", "a.ply"});
  CHECK_THAT(inspected.out, Contains(named));
  CHECK(inspected.err.empty());
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
