// convert and generate, as a user runs them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "io/clouds/open_point_source.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "io/points/point_source.h"
#include "tests/io/las_files.h"
#include "tests/support/data.h"
#include "tests/support/program.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;

namespace {

ProgramResult run_into(const ScratchDirectory& in, const std::vector<std::string>& arguments,
                       const std::filesystem::path& device) {
  return run_program(arguments, {.directory = in.path(), .out_to = device});
}

std::size_t entries(const ScratchDirectory& in) {
  const std::filesystem::directory_iterator all(in.path());
  return static_cast<std::size_t>(std::distance(begin(all), end(all)));
}

}  // namespace

TEST_CASE("GeneratedCloudsAreTheSameBytesEveryTime") {
  const ScratchDirectory in;
  const std::string shape =
      GENERATE("sphere", "torus", "bumpy-torus", "plane", "double-wall", "cube");
  CAPTURE(shape);
  for (const char* name : {"a.ply", "b.ply"}) {
    const auto result = run_in(in, {"generate", shape, "--points", "500", "--noise", "0.25",
                                    "--density", "varying", "--seed", "7", "-o", name});
    REQUIRE(result.status == 0);
    CHECK(result.err.empty());
  }
  CHECK(file_text(in / "a.ply") == file_text(in / "b.ply"));
  const PointCloud cloud = read_all(*open_point_source(in / "a.ply"));
  CHECK(cloud.size() == 500);
  CHECK(cloud.normals.size() == 500);
}

TEST_CASE("SeedChangesTheNoiseOnly") {
  const ScratchDirectory in;
  for (const char* seed : {"1", "2"}) {
    REQUIRE(run_in(in, {"generate", "sphere", "--points", "300", "--noise", "0.1", "--seed", seed,
                        "-o", std::string(seed) + ".ply"})
                .status == 0);
  }
  const PointCloud one = read_all(*open_point_source(in / "1.ply"));
  const PointCloud two = read_all(*open_point_source(in / "2.ply"));
  CHECK(one.positions != two.positions);
  CHECK(one.normals == two.normals);
}

TEST_CASE("TruthIsAClosedMeshWhereTheShapeIsClosed") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "torus", "--points", "100", "-o", "cloud.ply", "--truth",
                      "truth.ply"})
              .status == 0);
  const TriangleMesh truth = read_mesh(in / "truth.ply");
  CHECK(truth.triangles.size() == 2 * truth.vertices.size());  // Euler characteristic 0
}

TEST_CASE("DashWritesPlyToStandardOutput") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "cube", "--points", "200", "-o", "cloud.ply"}).status == 0);
  const auto streamed = run_in(in, {"generate", "cube", "--points", "200", "-o", "-"});
  CHECK(streamed.status == 0);
  CHECK(streamed.out == file_text(in / "cloud.ply"));
  CHECK(run_in(in, {"convert", "cloud.ply", "-"}).out == streamed.out);
}

TEST_CASE("CloudSurvivesEveryFormatAndComesBackTheSame") {
  const ScratchDirectory in;
  const std::string between = GENERATE("b.xyz", "b.csv", "b.ply.gz", "b.csv.gz");
  CAPTURE(between);
  REQUIRE(run_in(in, {"generate", "torus", "--points", "1000", "-o", "a.ply"}).status == 0);
  REQUIRE(run_in(in, {"convert", "a.ply", between}).status == 0);
  const auto back = run_in(in, {"convert", between, "c.ply"});
  CHECK(back.status == 0);
  CHECK_THAT(back.out, Contains("c.ply: 1,000 points"));
  CHECK(file_text(in / "a.ply") == file_text(in / "c.ply"));
}

TEST_CASE("PointsAreConvertedWhereTheHeaderSaysAnotherNumber") {
  const ScratchDirectory in;
  LasFile las;
  for (std::int32_t i = 0; i < 100; ++i) {
    LasPoint point;
    point.xyz = {i, i * i, 7};
    point.withheld = i % 3 == 0;
    las.add(point);
  }
  write_text(in / "withheld.las", las.bytes());
  write_text(in / "two_scans.pts", "3\n0 0 0\n1 0 0\n0 1 0\n2\n5 5 5\n6 6 6\n");
  const std::string to = GENERATE("to.ply", "to.xyz", "to.csv", "to.ply.gz");
  for (const auto& [from, points] :
       {std::pair("withheld.las", std::size_t{66}), {"two_scans.pts", 5}}) {
    CAPTURE(from, to);
    const auto result = run_in(in, {"convert", from, to});
    CHECK(result.status == 0);
    CHECK(result.err.empty());
    CHECK(read_all(*open_point_source(in / to)).size() == points);
  }
  CHECK(entries(in) == 3);
}

TEST_CASE("MeshStaysAMeshUnlessTheOutputIsACloud") {
  const ScratchDirectory in;
  REQUIRE(run_in(in, {"generate", "sphere", "--points", "9", "-o", "c.ply", "--truth", "m.ply"})
              .status == 0);
  const TriangleMesh mesh = read_mesh(in / "m.ply");
  for (const char* name : {"m.obj", "m2.ply", "-"}) {
    CAPTURE(name);
    CHECK(run_in(in, {"convert", "m.ply", name}).status == 0);
  }
  CHECK(read_mesh(in / "m.obj").triangles == mesh.triangles);
  CHECK(read_mesh(in / "m2.ply").vertices.positions == mesh.vertices.positions);
  REQUIRE(run_in(in, {"convert", "m.obj", "m.xyz"}).status == 0);
  CHECK(read_all(*open_point_source(in / "m.xyz")).positions == mesh.vertices.positions);
}

TEST_CASE("NormalsFromFacesMakeAnOrientedCloudThatCarriesAttributes") {
  const ScratchDirectory in;
  write_text(in / "m.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
             "property float z\nproperty uchar red\nelement face 1\n"
             "property list uchar int vertex_indices\nend_header\n"
             "0 0 5 10\n1 0 5 20\n0 1 5 30\n9 9 9 40\n3 0 1 2\n");
  const auto result = run_in(in, {"convert", "m.ply", "c.ply", "--normals-from-faces"});
  CHECK(result.status == 0);
  const PointCloud cloud = read_all(*open_point_source(in / "c.ply"));
  CHECK(cloud.positions == read_mesh(in / "m.ply").vertices.positions);
  CHECK(cloud.normals == std::vector<Vec3>(4, Vec3{0, 0, 1}));  // the last one from its nearest
  REQUIRE(cloud.schema.attributes.size() == 1);
  CHECK(attribute_value(cloud, 3, 0) == 40.0);
  CHECK(file_text(in / "c.ply").find("element face") == std::string::npos);
}

TEST_CASE("NormalsFromFacesOfACloudIsBadInput") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  const auto result = run_in(in, {"convert", "a.xyz", "b.ply", "--normals-from-faces"});
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("a.xyz") && Contains("no faces"));
  CHECK(entries(in) == 1);
}

TEST_CASE("FloatHalvesTheCoordinates") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", "0.1 0.2 0.3\n0.4 0.5 0.6\n");
  REQUIRE(run_in(in, {"convert", "a.xyz", "f.ply", "--float"}).status == 0);
  CHECK_THAT(file_text(in / "f.ply"), Contains("property float x"));
  const PointCloud cloud = read_all(*open_point_source(in / "f.ply"));
  CHECK(cloud.positions[0].x == static_cast<double>(0.1F));
}

TEST_CASE("CloudIntoAMeshFormatIsWrongUsage") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  const std::string out = GENERATE("a.obj", "a.stl");
  const auto result = run_in(in, {"convert", "a.xyz", out});
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains(out) && Contains("reconstruct"));
  CHECK(entries(in) == 1);
}

TEST_CASE("WrongValuesOfGenerateAreWrongUsageAndLeaveNoFile") {
  const ScratchDirectory in;
  struct Case {
    std::vector<std::string> arguments;
    const char* fragment;
  };
  const Case given = GENERATE(
      values<Case>({{{"tors", "--points", "10"}, "Did you mean 'torus'?"},
                    {{"torus", "--points", "0"}, "at least one point"},
                    {{"torus", "--points", "2.5"}, "found \"2.5\", expected a whole number"},
                    {{"torus", "--points", "many"}, "--points"},
                    {{"torus", "--points", "10", "--noise", "-1"}, "noise"},
                    {{"torus", "--points", "10", "--noise", "nan"}, "--noise"},
                    {{"torus", "--points", "10", "--density", "sparse"}, "--density"}}));
  std::vector<std::string> arguments = {"generate"};
  arguments.insert(arguments.end(), given.arguments.begin(), given.arguments.end());
  arguments.insert(arguments.end(), {"-o", "cloud.ply"});
  const auto result = run_in(in, arguments);
  CHECK(result.status == 2);
  CHECK_THAT(result.err, Contains(given.fragment));
  CHECK(entries(in) == 0);
}

TEST_CASE("FullDiskIsAResourceErrorThatGivesTheReason") {
  const ScratchDirectory in;
  if (skipped_without("/dev/full")) return;
  const auto result =
      run_into(in, {"generate", "sphere", "--points", "100000", "-o", "-"}, "/dev/full");
  CHECK(result.status == 4);
  CHECK_THAT(result.err, Contains("standard output") && Contains("No space left"));
  const ProgramResult help = run_into(in, {"--help"}, "/dev/full");
  CHECK(help.status == 4);
  CHECK_THAT(help.err,
             Contains("cannot write to standard output") && Contains("No space left on device"));
}

TEST_CASE("DamagedInputOfConvertLeavesNoOutput") {
  const ScratchDirectory in;
  write_text(in / "a.xyz", "0 0 0\n1 0 0\n0 y 0\n");
  const auto result = run_in(in, {"convert", "a.xyz", "b.ply"});
  CHECK(result.status == 3);
  CHECK_THAT(result.err, Contains("a.xyz: line 3"));
  CHECK(entries(in) == 1);
}

TEST_CASE("PlacesOfScannersThatNoCloudHasAreNamed") {
  const ScratchDirectory in;
  const std::string scan =
      "1\n2\n1.5 2 3\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n1.5 2 3 1\n"
      "1 1 1 0.5\n1 2 1 0.5\n";
  write_text(in / "one.ptx", scan);
  write_text(in / "two.ptx", scan + scan);
  write_text(in / "seen.pcd",
             "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
             "VIEWPOINT 0 0 9 1 0 0 0\nPOINTS 1\nDATA ascii\n1 2 3\n");
  write_text(in / "plain.xyz", "1 2 3\n");
  const auto told = [&](const char* file) { return run_in(in, {"convert", file, "out.ply"}).out; };
  CHECK_THAT(told("one.ptx"), Contains("left out: the place of the scanner; --scanner=1.5,2,3 of "
                                       "'orbweave reconstruct' turns normals towards it\n"));
  CHECK_THAT(told("two.ptx"), Contains("left out: the places of 2 scanners; a job that reads"));
  CHECK_THAT(told("seen.pcd"), Contains("--scanner=0,0,9 of"));
  CHECK_THAT(told("plain.xyz"), !Contains("left out"));
}

TEST_CASE("RowsThatAReaderTakesForNoPointsAreCounted") {
  const ScratchDirectory in;
  write_text(in / "pulses.ptx",
             "1\n3\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
             "1 2 3 0.5\n0 0 0 0.5\n0 0 0 0.5\n");
  CHECK_THAT(run_in(in, {"convert", "pulses.ptx", "out.ply"}).out,
             Contains("2 dropped: no return\nout.ply: 1 point\n"));
  CHECK(run_in(in, {"convert", "pulses.ptx", "-"}).out == file_text(in / "out.ply"));
}

TEST_CASE("OnePointOrTriangleIsNotSeveral") {
  const ScratchDirectory in;
  write_text(in / "one.xyz", "1 2 3\n");
  write_text(in / "short.pts", "2\n1 2 3\n");
  write_text(in / "one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  CHECK(run_in(in, {"convert", "one.xyz", "one.ply"}).out == "one.ply: 1 point\n");
  CHECK(run_in(in, {"convert", "one.obj", "mesh.ply"}).out == "mesh.ply: 3 vertices, 1 triangle\n");
  CHECK_THAT(run_in(in, {"inspect", "short.pts"}).err, Contains("found 1 point, expected 2"));
}
