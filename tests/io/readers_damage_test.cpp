// What a user is told about a file that is not what it should be.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "io/report/report.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Catch::Contains;
using test::reading_error;
using test::ScratchDirectory;
using test::write_file;

const std::string kBinaryHeader =
    "ply\nformat binary_little_endian 1.0\nelement vertex 100\nproperty float x\n"
    "property float y\nproperty float z\nend_header\n";

std::string ascii_ply(const std::string& count, const std::string& body) {
  return "ply\nformat ascii 1.0\nelement vertex " + count +
         "\nproperty float x\nproperty uchar y\nproperty float z\nend_header\n" + body;
}

/// Writes the content as `name` and checks that reading it is bad input and says all the words.
void check_refused(const std::string& name, const std::string& content,
                   const std::vector<std::string>& words) {
  const ScratchDirectory scratch;
  write_file(scratch / name, content);
  const Error error = reading_error(scratch / name);
  INFO(name << ": " << error.what());
  CHECK(error.kind() == ErrorKind::kBadInput);
  CHECK_THAT(error.what(), Contains((scratch / name).string()));
  for (const std::string& word : words) CHECK_THAT(error.what(), Contains(word));
}

TriangleMesh read_mesh_text(const std::string& name, const std::string& content) {
  const ScratchDirectory scratch;
  write_file(scratch / name, content);
  return read_mesh(scratch / name);
}

}  // namespace

TEST_CASE("TextStlFilesThatAreNoWholeFacetsNameLineAndWhatIsExpected") {
  const std::string solid = "solid a\n", facet = "facet normal 0 0 1\n", loop = "outer loop\n",
                    corners = "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n",
                    end = "endloop\nendfacet\n", last = "endsolid a\n";
  CHECK(read_mesh_text("a.stl", solid + facet + loop + corners + end + last).triangles.size() == 1);
  CHECK(read_mesh_text("b.stl", solid + last).triangles.empty());
  check_refused("c.stl", solid + facet + last, {"line 3", "\"endsolid\"", "expected outer loop"});
  check_refused("d.stl", solid + facet + facet + last, {"line 3", "\"facet\"", "outer loop"});
  CHECK(read_mesh_text("e.stl", solid + facet + corners + "endfacet\n" + last).triangles.size() ==
        1);
  check_refused("o.stl", solid + facet + corners + last, {"line 6", "\"endsolid\"", "endfacet"});
  check_refused("p.stl", solid + facet + "vertex 0 0 0\nendfacet\n" + last,
                {"line 4", "fewer than three corners", "found 1"});
  check_refused("q.stl", solid + facet + "endfacet\n" + last,
                {"line 3", "\"endfacet\"", "expected outer loop"});
  check_refused("f.stl", solid + facet + loop + end + last,
                {"line 4", "fewer than three corners", "found 0"});
  check_refused("g.stl", solid + facet + loop + corners + last,
                {"line 7", "\"endsolid\"", "expected endloop"});
  check_refused("h.stl", solid + facet + loop + corners + "endloop\n" + last,
                {"line 8", "\"endsolid\"", "expected endfacet"});
  check_refused("i.stl", solid + facet + loop + corners + corners + end + last,
                {"line 7", "more than three corners"});
  check_refused("j.stl", solid + facet + "outer circle\n" + corners + end + last,
                {"line 3", "outer loop"});
  check_refused("k.stl", solid + facet + loop + "vertex 0 0 0 0\n" + corners + end + last,
                {"line 4", "more than three coordinates"});
  check_refused("l.stl", solid + facet + loop + corners + end, {"ends early", "\"endsolid\""});
  check_refused("m.stl", solid + facet + loop + "vertex 0 0 0\n", {"ends early", "vertex"});
  check_refused("n.stl", solid + last + "vertex 0 0 0\n", {"line 3", "expected facet or endsolid"});
}

TEST_CASE("KeywordsOfTextStlFilesMayBeCapitals") {
  const std::string content =
      "SOLID A\n  FACET NORMAL 0 0 1\n    OUTER LOOP\n      VERTEX 0 0 0\n      VERTEX 1 0 0\n"
      "      Vertex 0 1 0\n    ENDLOOP\n  ENDFACET\nENDSOLID A\n";
  for (const char* front : {"", " ", "\r\n"}) {
    const TriangleMesh mesh = read_mesh_text("a.stl", front + content);
    CHECK(mesh.vertices.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}});
  }
  check_refused("b.stl", "SOLID A\nFACET NORMAL 0 0 1\nOUTER CIRCLE\n" + std::string(80, ' '),
                {"line 3", "\"OUTER\"", "outer loop"});
}

TEST_CASE("BinaryStlFilesOfATitleThatBeginsWithSolidAreBinary") {
  std::string content(80 + 4 + 2 * 50, '\0');
  content.replace(0, 9, "solid by ");
  content[80] = 2;
  const float one = 1.0F;
  for (const std::size_t place : {84 + 12 + 12, 84 + 12 + 28, 134 + 12 + 12, 134 + 12 + 32})
    std::memcpy(content.data() + place, &one, sizeof one);
  const ScratchDirectory scratch;
  for (const char title_end : {'\0', ' '}) {
    std::replace(content.begin() + 9, content.begin() + 80, content[9], title_end);
    CHECK(read_mesh_text("a.stl", content).triangles.size() == 2);
    test::gzip_file(scratch / "a.stl.gz", content);
    CHECK(read_mesh(scratch / "a.stl.gz").triangles.size() == 2);
    check_refused("b.stl", content.substr(0, 180),
                  {"byte 84", "ends early", "found 1 triangle", "expected 2"});
    check_refused("c.stl", content + "x", {"byte 184", "goes on after its last triangle"});
  }
}

TEST_CASE("ObjLinesWithWordsForNumbersNameTheirLine") {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  CHECK(read_mesh_text("a.obj", "v 0 0 0 1\nv 1 0 0 # a comment\nv 0 1 0 1 1 1\nf 1/1 2/ 3\n")
            .triangles.size() == 1);
  check_refused("b.obj", corners + "v 1 1 1 red\nf 1 2 3\n", {"line 4", "no number", "\"red\""});
  check_refused("c.obj", corners + "f 1/x 2/y 3/z\n", {"line 4", "no index", "\"x\""});
  check_refused("d.obj", corners + "f 1//9 2//1 3//1\nvn 0 0 1\n",
                {"line 4", "a normal that is not there", "found 9", "expected 1 to 1"});
  CHECK(read_mesh_text("e.obj", corners + "f 1//1 2//1 3//1\n").triangles.size() == 1);
  check_refused("f.obj", corners + "f -1//-2 2//-1 3//-1\nvn 0 0 1\n",
                {"line 4", "a normal that is not there", "\"-2\""});
  check_refused("g.obj", corners + "f -4 2 3\n",
                {"line 4", "a vertex that is not there", "\"-4\"", "down to -3"});
}

TEST_CASE("CornersOfObjFacesMayLeaveTheirNormalEmpty") {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n";
  for (const char* face : {"f 1// 2// 3//\n", "f 1/1/ 2/1/ 3/1/\n", "f -3// -2// -1//\n"}) {
    INFO(face);
    const TriangleMesh mesh = read_mesh_text("a.obj", corners + face);
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}});
    CHECK_FALSE(mesh.vertices.schema.has_normals);
  }
}

TEST_CASE("TruncatedBinaryPlyIsRefused") {
  check_refused("a.ply", kBinaryHeader + std::string(99 * 12 + 11, '\0'),
                {"shorter than its header says", "99 rows", "100 rows"});
  check_refused("b.ply", kBinaryHeader, {"room for 0 rows", "100 rows"});
}

TEST_CASE("TruncatedPlyWithListsNamesByteAndRow") {
  std::string content =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty list uchar uchar l\n"
      "property uchar x\nproperty uchar y\nproperty uchar z\nend_header\n";
  const std::size_t body = content.size();
  content += std::string("\x04zzzz\x01\x02\x03", 8) + std::string("\x05zzz", 4);
  check_refused(
      "a.ply", content + std::string(1, '\0'),
      {"byte " + std::to_string(body + 13), "vertex 1", "found 1 whole row, expected 3 rows"});
}

TEST_CASE("AHeaderThatPromisesTooMuchDoesNotAllocate") {
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const std::string count : {"9223372036854775808", "18446744073709551615"}) {
      const std::uint64_t before = peak_memory_bytes();
      check_refused(
          "a.ply",
          "ply\nformat " + format + " 1.0\nelement vertex " + count +
              "\nproperty uchar x\nproperty uchar y\nproperty uchar z\n"
              "element face " +
              count + "\nproperty list uchar int vertex_indices\nend_header\n1 2 3\n",
          {format == "ascii" ? "found 1 whole row, " : "shorter than its header says", count});
      CHECK(peak_memory_bytes() - before < 50'000'000);
    }
  }
}

TEST_CASE("ACompressedFileThatEndsEarlyIsRefusedWithoutAllocating") {
  const ScratchDirectory scratch;
  test::gzip_file(scratch / "b.ply.gz",
                  "ply\nformat binary_little_endian 1.0\nelement vertex 9223372036854775808\n"
                  "property uchar x\nproperty uchar y\nproperty uchar z\nend_header\nabcdef");
  const std::uint64_t before = peak_memory_bytes();
  const Error error = reading_error(scratch / "b.ply.gz");
  CHECK(error.kind() == ErrorKind::kBadInput);
  CHECK_THAT(error.what(), Contains("2 whole rows"));
  CHECK(peak_memory_bytes() - before < 50'000'000);
}

TEST_CASE("AHeaderThatPromisesTooLittleIsRefused") {
  check_refused("a.ply", ascii_ply("2", "1 2 3\n1 2 3\n4 5 6\n"),
                {"goes on after its last row", "2 rows"});
  check_refused("b.ply", kBinaryHeader + std::string(1200, '\0') + std::string(12, '\x01'),
                {"goes on after its last row", "100 rows"});
}

TEST_CASE("AsciiRowsThatDoNotFitNameTheirLine") {
  check_refused("a.ply", ascii_ply("2", "1 2 3\n1 2\n"), {"line 9", "fewer values", "property z"});
  check_refused("b.ply", ascii_ply("2", "1 2 3\n1 2 3 4\n"), {"line 9", "more values", "\"4\""});
  check_refused("c.ply", ascii_ply("2", "1 2 3\n1 x 3\n"), {"line 9", "property y", "\"x\""});
  check_refused("d.ply", ascii_ply("2", "1 2 3\n1 256 3\n"),
                {"line 9", "property y", "\"256\"", "0 to 255"});
  check_refused("e.ply", ascii_ply("2", "1 2 3\n1 1.5 3\n"), {"line 9", "\"1.5\"", "0 to 255"});
}

TEST_CASE("DamagedPlyHeadersNameTheirLine") {
  check_refused("a.ply", "plz\nformat ascii 1.0\n", {"no PLY file", "\"plz"});
  check_refused("b.ply", "ply\nformat ascii 2.0\n", {"line 2", "format"});
  check_refused("c.ply", "ply\nelement vertex 1\nend_header\n", {"no format line"});
  check_refused("d.ply", "ply\nformat ascii 1.0\nelement vertex -1\n", {"line 3", "count of rows"});
  check_refused("e.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\n",
                {"line 4", "unknown type", "\"real\""});
  check_refused("f.ply", "ply\nformat ascii 1.0\nproperty float x\n", {"line 3", "before any"});
  check_refused("g.ply", "ply\nformat ascii 1.0\nelement vertex 1\nvertices 5\n",
                {"line 4", "\"vertices 5\""});
  check_refused("h.ply",
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float x\n",
                {"line 5", "twice", "\"x\""});
  check_refused("i.ply", "ply\nformat ascii 1.0\nelement vertex 1\n", {"no end", "end_header"});
}

TEST_CASE("MissingDirectoryUnreadableAndEmptyFilesAreTold") {
  const ScratchDirectory scratch;
  CHECK_THAT(reading_error(scratch / "none.ply").what(), Contains("no such file"));
  CHECK(reading_error(scratch / "none.ply").kind() == ErrorKind::kBadInput);
  CHECK_THAT(reading_error(scratch.path()).what(), Contains("is a directory"));
  CHECK(reading_error(scratch.path()).kind() == ErrorKind::kBadInput);
  check_refused("empty.ply", "", {"empty"});
  check_refused("empty.xyz", "", {"empty"});
  if (::geteuid() == 0) return;  // root may read anything
  write_file(scratch / "secret.xyz", "1 2 3\n");
  ::chmod((scratch / "secret.xyz").c_str(), 0);
  CHECK_THAT(reading_error(scratch / "secret.xyz").what(), Contains("cannot open"));
}

TEST_CASE("UnknownExtensionsAreAUsageErrorThatListsTheKnown") {
  const ScratchDirectory scratch;
  write_file(scratch / "a.foo", "1 2 3\n");
  const Error error = reading_error(scratch / "a.foo");
  CHECK(error.kind() == ErrorKind::kUsage);
  for (const char* known :
       {".ply", ".xyz", ".xyzn", ".xyzrgb", ".asc", ".txt", ".csv", ".pts", ".ptx", ".pcd", ".gz"})
    CHECK_THAT(error.what(), Contains(known));
}

TEST_CASE("ContentThatBeliesTheExtensionIsTold") {
  check_refused("a.ply", "1 2 3\n4 5 6\n", {"no PLY file", "\"ply\""});
  check_refused("a.xyz", std::string("LASF\0\0\1\2\3", 9), {"LASF", "named .las or .laz"});
  check_refused("a.txt", std::string("ASTM-E57\1\0\0\0", 12), {"ASTM-E57", "named .e57"});
  check_refused("a.xyz", std::string("\x89PNG\r\n\x1a\n", 8), {"line 1"});
  check_refused("a.xyz.gz", "1 2 3\n", {"damaged", "gzip"});
  const ScratchDirectory scratch;
  write_file(scratch / "ply.txt", ascii_ply("1", "1 2 3\n"));
  CHECK(test::read_cloud(scratch / "ply.txt").size() == 1);
}

TEST_CASE("ACloudThatIsStillCompressedIsToldAsThat") {
  const ScratchDirectory scratch;
  test::gzip_file(scratch / "once.xyz.gz", "1 2 3\n");
  test::gzip_file(scratch / "twice.xyz.gz", test::read_file(scratch / "once.xyz.gz"));
  CHECK_THAT(reading_error(scratch / "twice.xyz.gz").what(),
             Contains("compressed by gzip") && Contains("gunzip -c"));
}

TEST_CASE("DamagedGzipIsRefused") {
  const ScratchDirectory scratch;
  PointCloud cloud;
  for (int i = 0; i < 5000; ++i) cloud.positions.push_back({1.0 / (i + 1), 0.1 * i, 7.0});
  for (const std::string name : {"a.xyz.gz", "a.ply.gz", "a.csv.gz"}) {
    write_cloud(scratch / name, cloud);
    const std::string good = test::read_file(scratch / name);
    REQUIRE(test::read_cloud(scratch / name).positions == cloud.positions);
    check_refused("short-" + name, good.substr(0, good.size() / 2), {"ends early"});
    check_refused("tail-" + name, good.substr(0, good.size() - 4), {"ends early"});
    check_refused("more-" + name, good + "x",
                  {"goes on behind its compressed data", "byte " + std::to_string(good.size())});
    // Zeros behind it fill a block, as gzip takes them.
    const std::string zeros(name == "a.ply.gz" ? 600'000 : 512, '\0');
    write_file(scratch / ("filled-" + name), good + zeros);
    CHECK(test::read_cloud(scratch / ("filled-" + name)).positions == cloud.positions);
    check_refused("filled-more-" + name, good + zeros + "x",
                  {"goes on behind its compressed data",
                   "byte " + std::to_string(good.size() + zeros.size())});
    check_refused("filled-short-" + name, good.substr(0, good.size() - 4) + zeros, {"damaged"});
    std::string flipped = good;
    flipped[good.size() - 6] ^= 1;  // the checksum
    check_refused("flipped-" + name, flipped, {"damaged"});
  }
}

TEST_CASE("GzipMembersAndPlainNamesAreReadAlike") {
  const ScratchDirectory scratch;
  PointCloud cloud;
  cloud.positions = {{1, 2, 3}, {4, 5, 6}};
  write_cloud(scratch / "a.xyz.gz", cloud);
  const std::string member = test::read_file(scratch / "a.xyz.gz");
  write_file(scratch / "two.xyz.gz", member + member);
  CHECK(test::read_cloud(scratch / "two.xyz.gz").size() == 4);
  write_file(scratch / "unnamed.xyz", member);
  CHECK(test::read_cloud(scratch / "unnamed.xyz").positions == cloud.positions);
}

TEST_CASE("FacesThatNameAbsentVerticesAreRefused") {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  CHECK_THROWS_WITH(read_mesh_text("a.ply", ply + "3 0 1 3\n"),
                    Contains("face 1") && Contains("vertex 3"));
  CHECK_THROWS_WITH(read_mesh_text("a.ply", ply + "3 0 1 -1\n"), Contains("vertex -1"));
  CHECK_THROWS_WITH(read_mesh_text("a.ply", ply), Contains("element face"));
  CHECK_THROWS_WITH(read_mesh_text("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n"),
                    Contains("line 3") && Contains("found 3"));
  CHECK_THROWS_WITH(read_mesh_text("a.obj", "v 0 0 0\nf 1 0 1\n"), Contains("line 2"));
  CHECK_THROWS_WITH(read_mesh_text("a.obj", "v 0 0 a\n"), Contains("line 1"));
  CHECK_THROWS_WITH(read_mesh_text("a.stl", "solid\nfacet\nvertex 0 0\n"), Contains("line 3"));
  CHECK_THROWS_WITH(read_mesh_text("a.stl", "solid\nfacet\nvertex 0 0 0\n"),
                    Contains("ends early"));
  CHECK_THROWS_WITH(read_mesh_text("a.stl", std::string(80, 'b') + test::raw(2U) + "xyz"),
                    Contains("0 triangles"));
}

}  // namespace orbweave
