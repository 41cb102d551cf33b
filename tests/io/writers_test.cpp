#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <stdexcept>

#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "io/ply/ply_rows.h"
#include "io/streams/byte_source.h"
#include "io/system/atomic_file.h"
#include "io/system/placed_file.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Catch::Contains;
using test::read_file;
using test::ScratchDirectory;

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.2, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  return mesh;
}

TriangleMesh dressed_tetrahedron() {
  TriangleMesh mesh = tetrahedron();
  mesh.vertices.schema.has_normals = true;
  mesh.vertices.schema.attributes = {{"red", ScalarType::kUint8},
                                     {"gps time", ScalarType::kFloat64}};
  mesh.vertices.normals = {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < 4; ++i) {
    mesh.vertices.attributes.push_back(static_cast<std::byte>(i));
    for (const char c : test::raw(0.1 * i))
      mesh.vertices.attributes.push_back(static_cast<std::byte>(c));
  }
  mesh.hole = {0, 0, 3, 3};
  return mesh;
}

/// What `write` throws where no file may have more bytes; kNone where it throws nothing.
Error with_files_of(rlim_t bytes, const std::function<void()>& write) {
  rlimit old{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &old) == 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{bytes, old.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  Error thrown(ErrorKind::kNone, "");
  try {
    write();
  } catch (const Error& error) {
    thrown = error;
  }
  ::setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, handler);
  return thrown;
}

MeshHeader header_of(const TriangleMesh& mesh) {
  MeshHeader header;
  header.vertices = mesh.vertices.size();
  header.triangles = mesh.triangles.size();
  header.schema = mesh.vertices.schema;
  header.has_hole = !mesh.hole.empty();
  return header;
}

std::size_t files_in(const std::filesystem::path& directory) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    (void)entry;
    ++count;
  }
  return count;
}

}  // namespace

TEST_CASE("PolygonsAreReadBackInFansFromTheirFirstCorners") {
  const ScratchDirectory scratch;
  PointCloud corners = dressed_tetrahedron().vertices;
  corners.append(corners, 0);  // a fifth, for a face of four corners beside triangles
  corners.positions[4] = {0, 1, 1};
  const PolygonFaces faces{{0, 2, 4, 3, 0, 1, 2, 3, 1, 0, 1, 3, 4, 2}, {0, 4, 7, 10, 14}};
  const std::vector<Triangle> expected = {{0, 2, 4}, {0, 4, 3}, {0, 1, 2},
                                          {3, 1, 0}, {1, 3, 4}, {1, 4, 2}};
  for (const bool binary : {true, false})
    for (const char* name : {"mesh.ply", "mesh.obj"}) {
      MeshWriterOptions options;
      options.binary = binary;
      write_polygons(scratch / name, corners, faces, options);
      const TriangleMesh read = read_mesh(scratch / name);
      INFO(name << (binary ? ", binary" : ", text"));
      CHECK(read.triangles == expected);
      CHECK(read.vertices.positions == corners.positions);
      CHECK(read.vertices.normals == corners.normals);
    }
  CHECK_FALSE(holds_polygons("mesh.stl"));
  CHECK_THROWS_AS(write_polygons(scratch / "mesh.stl", corners, faces), Error);
}

TEST_CASE("AFaceOfManyCornersFitsAPlyFile") {
  const ScratchDirectory scratch;
  PointCloud corners;
  PolygonFaces faces;
  for (std::uint32_t i = 0; i < 300; ++i) {
    corners.positions.push_back({1.0 * i, 1.0 * i * i, 0.0});
    faces.corners.push_back(i);
  }
  faces.begin.push_back(300);
  write_polygons(scratch / "mesh.ply", corners, faces);
  const TriangleMesh read = read_mesh(scratch / "mesh.ply");
  REQUIRE(read.triangles.size() == 298);
  CHECK(read.triangles.back() == Triangle{0, 298, 299});
}

TEST_CASE("PlyMeshesReadBackWhole") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = dressed_tetrahedron();
  for (const bool binary : {true, false}) {
    MeshWriterOptions options;
    options.binary = binary;
    write_mesh(scratch / "a.ply", mesh, options);
    const TriangleMesh back = read_mesh(scratch / "a.ply");
    CHECK(back.vertices.positions == mesh.vertices.positions);
    CHECK(back.vertices.normals == mesh.vertices.normals);
    CHECK(back.vertices.attributes == mesh.vertices.attributes);
    CHECK(back.vertices.schema.attributes[1].name == "gps_time");
    CHECK(back.vertices.schema.position_type == ScalarType::kFloat64);
    CHECK(back.triangles == mesh.triangles);
    CHECK(back.hole == mesh.hole);
  }
}

TEST_CASE("AMeshWhoseColumnsDoNotBelongTogetherIsNotWritten") {
  const ScratchDirectory scratch;
  const auto refused = [&](const char* problem, void (*spoil)(TriangleMesh&)) {
    TriangleMesh mesh = dressed_tetrahedron();
    spoil(mesh);
    CHECK_THROWS_WITH(write_mesh(scratch / "a.ply", mesh), Contains(problem));
    if (mesh.hole.size() != 1)
      CHECK_THROWS_WITH(write_cloud(scratch / "a.ply", mesh.vertices), Contains(problem));
    CHECK_FALSE(std::filesystem::exists(scratch / "a.ply"));
  };
  refused("1 numbers for 4 triangles", [](TriangleMesh& mesh) { mesh.hole.resize(1); });
  refused("1 normals for 4 positions", [](TriangleMesh& mesh) { mesh.vertices.normals.resize(1); });
  refused("has normals", [](TriangleMesh& mesh) { mesh.vertices.normals.clear(); });
  refused("not those of the schema", [](TriangleMesh& mesh) { mesh.vertices.attributes.clear(); });
  for (const char* name : {"b.ply", "b.obj", "b.stl", "b.glb", "b.vtp", "b.xdmf"}) {
    TriangleMesh mesh = dressed_tetrahedron();
    mesh.triangles[2][1] = 4;
    CHECK_THROWS_WITH(write_mesh(scratch / name, mesh),
                      Contains("triangle 2") && Contains("found 4, expected a number below 4"));
    CHECK_FALSE(std::filesystem::exists(scratch / name));
  }
}

TEST_CASE("PlyBytesAreTheDocumentedOnes") {
  const ScratchDirectory scratch;
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.resize(1);
  mesh.hole = {5};
  MeshWriterOptions options;
  options.float_positions = true;
  options.comments = {"two\nlines"};
  write_mesh(scratch / "a.ply", mesh, options);
  std::string expected =
      "ply\nformat binary_little_endian 1.0\ncomment two lines\nelement vertex 4\n"
      "property float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nproperty int hole\nend_header\n";
  for (const Vec3& p : mesh.vertices.positions)
    for (int axis = 0; axis < 3; ++axis) expected += test::raw(static_cast<float>(p[axis]));
  expected += "\x03" + test::raw(0) + test::raw(2) + test::raw(1) + test::raw(5);
  CHECK(read_file(scratch / "a.ply") == expected);
}

TEST_CASE("FacesCarryTheConfidenceOfTheirPatchesWhereItIsAskedFor") {
  const ScratchDirectory scratch;
  TriangleMesh mesh = tetrahedron();
  mesh.triangles.resize(2);
  mesh.hole = {0, 2};
  MeshWriterOptions options;
  options.has_confidence = true;
  options.confidence = {0.5F, 0.25F};
  write_mesh(scratch / "a.ply", mesh, options);
  const std::string bytes = read_file(scratch / "a.ply");
  CHECK_THAT(bytes, Contains("property int hole\nproperty float confidence\nend_header\n"));
  const std::string faces = "\x03" + test::raw(0) + test::raw(2) + test::raw(1) + test::raw(0) +
                            test::raw(1.0F) + "\x03" + test::raw(0) + test::raw(1) + test::raw(3) +
                            test::raw(2) + test::raw(0.25F);
  CHECK(bytes.ends_with(faces));
  options.binary = false;
  write_mesh(scratch / "a.ply", mesh, options);
  CHECK(read_file(scratch / "a.ply").ends_with("3 0 2 1 0 1\n3 0 1 3 2 0.25\n"));
  CHECK(read_mesh(scratch / "a.ply").hole == mesh.hole);
  // Without ids of holes there is nothing to look up.
  mesh.hole.clear();
  write_mesh(scratch / "a.ply", mesh, options);
  CHECK_THAT(read_file(scratch / "a.ply"), !Contains("confidence"));
}

TEST_CASE("BatchesAndParallelEncodingDoNotChangeTheBytes") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = dressed_tetrahedron();
  for (const std::string name : {"a.ply", "a.obj"}) {
    write_mesh(scratch / ("whole-" + name), mesh);
    const auto writer = open_mesh_writer(scratch / name, header_of(mesh));
    REQUIRE(writer->encodes_independently());
    std::vector<std::vector<std::byte>> encoded;
    for (std::size_t i = 0; i < 4; ++i) {
      PointCloud one;
      one.schema = mesh.vertices.schema;
      one.append(mesh.vertices, i);
      encoded.push_back(writer->encode_vertices(one));
    }
    for (const auto& bytes : encoded) writer->write_encoded_vertices(bytes, 1);
    for (std::size_t i = 0; i < 4; ++i) {
      const Triangle64 t = {mesh.triangles[i][0], mesh.triangles[i][1], mesh.triangles[i][2]};
      writer->write_triangles(std::span(&t, 1), std::span(&mesh.hole[i], 1));
    }
    writer->finish();
    CHECK(read_file(scratch / name) == read_file(scratch / ("whole-" + name)));
    CHECK(writer->bytes_written() == std::filesystem::file_size(scratch / name));
  }
}

TEST_CASE("ObjAndStlMeshesReadBack") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = dressed_tetrahedron();
  write_mesh(scratch / "a.obj", mesh);
  const TriangleMesh obj = read_mesh(scratch / "a.obj");
  CHECK(obj.vertices.positions == mesh.vertices.positions);
  CHECK(obj.vertices.normals == mesh.vertices.normals);
  CHECK(obj.triangles == mesh.triangles);
  CHECK(test::read_cloud(scratch / "a.obj").positions == mesh.vertices.positions);

  MeshWriterOptions text;
  text.binary = false;
  write_mesh(scratch / "text.stl", mesh, text);
  const TriangleMesh stl = read_mesh(scratch / "text.stl");
  REQUIRE(stl.triangles.size() == 4);
  CHECK(stl.vertices.size() == 4);
  CHECK(stl.vertices.positions[1] == mesh.vertices.positions[2]);  // numbered as they appear
  write_mesh(scratch / "binary.stl", mesh);
  CHECK(std::filesystem::file_size(scratch / "binary.stl") == 84 + 4 * 50);
  const TriangleMesh narrow = read_mesh(scratch / "binary.stl");
  CHECK(narrow.triangles == stl.triangles);
  CHECK(narrow.vertices.positions[3].x == static_cast<double>(0.1f));
  CHECK(files_in(scratch.path()) == 3);
}

TEST_CASE("ObjLinesMayGoOnBehindABackslashAndEndInAComment") {
  const ScratchDirectory scratch;
  test::write_file(scratch / "m.obj",
                   "# C:\\models\\\nv 0 0 0\nv 1 0 \\\n 0\nv 1 1 0\r\nv 0 1 0\n"
                   "f 1 2 \\\r\n3 \\\n4 # a square\n");
  const TriangleMesh mesh = read_mesh(scratch / "m.obj");
  CHECK(mesh.vertices.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("StlNormalsAreThoseOfTheTriangles") {
  const ScratchDirectory scratch;
  MeshWriterOptions text;
  text.binary = false;
  write_mesh(scratch / "a.stl", tetrahedron(), text);
  CHECK_THAT(read_file(scratch / "a.stl"), Contains("facet normal 0 0 -1\n"));
}

TEST_CASE("TextCloudsReadBackExactly") {
  const ScratchDirectory scratch;
  PointCloud cloud;
  cloud.schema.has_normals = true;
  cloud.schema.normal_type = ScalarType::kFloat64;
  cloud.schema.attributes = {{"red", ScalarType::kUint8},
                             {"green", ScalarType::kUint8},
                             {"blue", ScalarType::kUint8},
                             {"t", ScalarType::kFloat64}};
  for (int i = 0; i < 500; ++i) {
    cloud.positions.push_back({1.0 / (i + 3), -1e-7 * i, 1e12 + 0.1 * i});
    cloud.normals.push_back(normalized({1.0 * i, 1.0, -0.5}));
    for (int c = 0; c < 3; ++c) cloud.attributes.push_back(static_cast<std::byte>(i + c));
    for (const char c : test::raw(1.5 + i)) cloud.attributes.push_back(static_cast<std::byte>(c));
  }
  for (const std::string name : {"a.csv", "a.csv.gz", "a.xyz", "a.xyz.gz"}) {
    INFO(name);
    write_cloud(scratch / name, cloud);
    PointCloud back = test::read_cloud(scratch / name);
    CHECK(back.positions == cloud.positions);
    CHECK(back.normals == cloud.normals);
    CHECK(back.attributes == cloud.attributes);
  }
  CHECK_THAT(read_file(scratch / "a.csv"), Catch::StartsWith("x,y,z,nx,ny,nz,red,green,blue,t\n"));
}

TEST_CASE("NamesThatAreTakenGetNumbersAndTheFileReadsBack") {
  using Names = std::vector<std::string>;
  const ScratchDirectory scratch;
  PointCloud cloud;
  cloud.schema.has_normals = true;
  for (const char* name : {"x", "nx", "a b", "a_b", "same", "same"})
    cloud.schema.attributes.push_back({name, ScalarType::kUint8});
  cloud.positions = {{1, 2, 3}};
  cloud.normals = {{0, 0, 1}};
  cloud.attributes = {std::byte{1}, std::byte{2}, std::byte{3},
                      std::byte{4}, std::byte{5}, std::byte{6}};
  const auto names_from = [&](const char* file) {
    write_cloud(scratch / file, cloud);
    const PointCloud back = test::read_cloud(scratch / file);
    CHECK(back.positions == cloud.positions);
    CHECK(back.normals == cloud.normals);
    CHECK(test::value_of(back, 0, "x_2") == 1);
    return test::attribute_names(back.schema);
  };
  CHECK(names_from("a.ply") == Names{"x_2", "nx_2", "a_b_2", "a_b", "same", "same_2"});
  CHECK(names_from("a.csv") == Names{"x_2", "nx_2", "a b", "a_b", "same", "same_2"});
}

TEST_CASE("NamesThatReadersTakeForTheSameAreToldApartInCsv") {
  const ScratchDirectory scratch;
  PointCloud cloud;
  for (const char* name : {"X", "red", "R"})
    cloud.schema.attributes.push_back({name, ScalarType::kUint8});
  cloud.positions = {{1, 2, 3}};
  cloud.attributes.resize(3);
  write_cloud(scratch / "a.csv", cloud);
  CHECK(test::attribute_names(test::read_cloud(scratch / "a.csv").schema) ==
        std::vector<std::string>{"X_2", "red", "R_2"});
}

TEST_CASE("NamesThatWouldCutALineOfCsvOtherwiseAreReadBack") {
  const ScratchDirectory scratch;
  PointCloud cloud;
  for (const char* name : {"a;b", "", " "})
    cloud.schema.attributes.push_back({name, ScalarType::kUint8});
  cloud.positions = {{1, 2, 3}};
  cloud.attributes.resize(3);
  write_cloud(scratch / "a.csv", cloud);
  CHECK(test::attribute_names(test::read_cloud(scratch / "a.csv").schema) ==
        std::vector<std::string>{"a_b", "_", "__2"});
}

TEST_CASE("TextBetweenBlanksSaysInACommentWhatItsColumnsAre") {
  using Names = std::vector<std::string>;
  const ScratchDirectory scratch;
  PointCloud cloud;
  for (const char* name : {"classification", "return number", "", "\"n"})
    cloud.schema.attributes.push_back({name, ScalarType::kUint8});
  cloud.positions = {{1, 2, 3}, {4, 5, 6}};
  for (int i = 0; i < 8; ++i) cloud.attributes.push_back(static_cast<std::byte>(i));
  write_cloud(scratch / "a.xyz", cloud);
  CHECK(read_file(scratch / "a.xyz") ==
        "# x y z classification return_number _ _n\n1 2 3 0 1 2 3\n4 5 6 4 5 6 7\n");
  const PointCloud back = test::read_cloud(scratch / "a.xyz");
  CHECK(test::attribute_names(back.schema) == Names{"classification", "return_number", "_", "_n"});
  CHECK(test::value_of(back, 1, "return_number") == 5);

  cloud.schema.attributes.clear();
  cloud.attributes.clear();
  write_cloud(scratch / "bare.xyz", cloud);
  CHECK(read_file(scratch / "bare.xyz") == "1 2 3\n4 5 6\n");
  // Programs that read bare numbers alone read normals and colours, too.
  cloud.schema.has_normals = true;
  cloud.normals = {{0, 0, 1}, {1, 0, 0}};
  for (const char* name : {"red", "green", "blue"})
    cloud.schema.attributes.push_back({name, ScalarType::kUint8});
  for (int i = 0; i < 6; ++i) cloud.attributes.push_back(static_cast<std::byte>(i));
  write_cloud(scratch / "colors.xyz", cloud);
  CHECK(read_file(scratch / "colors.xyz") == "1 2 3 0 0 1 0 1 2\n4 5 6 1 0 0 3 4 5\n");
}

TEST_CASE("ANameOfNormalsStaysWhereThereAreNone") {
  const ScratchDirectory scratch;
  PointCloud cloud;
  cloud.schema.attributes = {{"nx", ScalarType::kUint8}};
  cloud.positions = {{1, 2, 3}};
  cloud.attributes.resize(1);
  write_cloud(scratch / "a.ply", cloud);
  CHECK(test::attribute_names(test::read_cloud(scratch / "a.ply").schema) ==
        std::vector<std::string>{"nx"});
}

TEST_CASE("SameContentSameBytes") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = dressed_tetrahedron();
  for (const std::string name : {"a.ply", "a.ply.gz", "a.obj", "a.stl"}) {
    write_mesh(scratch / name, mesh);
    write_mesh(scratch / ("again-" + name), mesh);
    CHECK(read_file(scratch / name) == read_file(scratch / ("again-" + name)));
  }
}

TEST_CASE("AHalfWrittenFileNeverAppears") {
  const ScratchDirectory scratch;
  test::write_file(scratch / "a.ply", "old");
  for (const std::string name : {"a.ply", "b.ply", "b.obj", "b.stl", "b.ply.gz"}) {
    const TriangleMesh mesh = tetrahedron();
    {
      const auto writer = open_mesh_writer(scratch / name, header_of(mesh));
      writer->write_vertices(mesh.vertices);
      if (name != "a.ply") CHECK_FALSE(std::filesystem::exists(scratch / name));
    }
    CHECK(files_in(scratch.path()) == 1);
  }
  CHECK(read_file(scratch / "a.ply") == "old");
}

TEST_CASE("FinishedFilesReplaceOlderOnesAndAreReadable") {
  const ScratchDirectory scratch;
  test::write_file(scratch / "a.ply", "old");
  write_mesh(scratch / "a.ply", tetrahedron());
  CHECK(read_mesh(scratch / "a.ply").triangles.size() == 4);
  CHECK(files_in(scratch.path()) == 1);
  struct stat facts {};
  REQUIRE(::stat((scratch / "a.ply").c_str(), &facts) == 0);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  CHECK((facts.st_mode & 0777) == (0666 & ~mask));
}

TEST_CASE("CountsThatDoNotMatchTheHeaderAreADefect") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = tetrahedron();
  const auto writer = open_mesh_writer(scratch / "a.ply", header_of(mesh));
  CHECK_THROWS_AS(writer->finish(), std::logic_error);
  const Triangle64 triangle = {0, 1, 2};
  CHECK_THROWS_AS(writer->write_triangles(std::span(&triangle, 1)), std::logic_error);
  writer->write_vertices(mesh.vertices);
  CHECK_THROWS_AS(writer->write_vertices(mesh.vertices), std::logic_error);
}

TEST_CASE("PathsThatCannotBeWrittenAreAResourceErrorWithPathAndReason") {
  const ScratchDirectory scratch;
  std::filesystem::create_directory(scratch / "directory.ply");
  for (const std::string name : {"missing/a.ply", "directory.ply"}) {
    try {
      write_mesh(scratch / name, tetrahedron());
      FAIL("written");
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kResource);
      CHECK(error.parts().file == (scratch / name).string());
      CHECK_THAT(error.what(), Contains("directory"));  // the system's reason
    }
  }
}

TEST_CASE("AFullDiskIsAResourceErrorThatNamesTheFileAndLeavesNothing") {
  const ScratchDirectory scratch;
  TriangleMesh mesh;
  mesh.vertices.positions.resize(1000);
  for (const std::string name : {"a.ply", "a.stl", "a.obj"}) {
    INFO(name);
    const Error refusal = with_files_of(1000, [&] { write_mesh(scratch / name, mesh); });
    CHECK(refusal.kind() == ErrorKind::kResource);
    CHECK_THAT(refusal.what(), Contains(name + ": cannot") && Contains("File too large") &&
                                   Contains("Raise the limit of file sizes"));
    CHECK(files_in(scratch.path()) == 0);
  }
}

TEST_CASE("ExtensionsNobodyWritesAreAUsageErrorBeforeAnyFile") {
  const ScratchDirectory scratch;
  for (const std::string name : {"a.foo", "a", "a.xyz", "a.obj.gz"}) {
    try {
      write_mesh(scratch / name, tetrahedron());
      FAIL("written");
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kUsage);
      CHECK_THAT(error.what(), Contains(".ply"));
    }
  }
  CHECK_THROWS_AS(write_cloud(scratch / "a.stl", tetrahedron().vertices), Error);
  CHECK(files_in(scratch.path()) == 0);
}

TEST_CASE("StandardStreamsCarryClouds") {
  const ScratchDirectory scratch;
  const PointCloud cloud = dressed_tetrahedron().vertices;
  for (const std::string name : {"a.ply", "a.csv"}) {
    write_cloud(scratch / name, cloud);
    const int input = ::dup(STDIN_FILENO);
    REQUIRE(std::freopen((scratch / name).c_str(), "rb", stdin) != nullptr);
    const PointCloud back = test::read_cloud("-");
    ::dup2(input, STDIN_FILENO);
    ::close(input);
    CHECK(back.positions == cloud.positions);
  }
  const int output = ::dup(STDOUT_FILENO);
  std::fflush(stdout);
  const int file = ::open((scratch / "out.ply").c_str(), O_WRONLY | O_CREAT, 0600);
  ::dup2(file, STDOUT_FILENO);
  write_cloud("-", cloud);
  ::dup2(output, STDOUT_FILENO);
  ::close(output);
  ::close(file);
  CHECK(read_file(scratch / "out.ply") == read_file(scratch / "a.ply"));
}

TEST_CASE("AtomicFilesWriteToDevicesDirectly") {
  AtomicFile file("/dev/null");
  file.write("gone");
  CHECK(file.temporary().empty());
  file.commit();
  CHECK(std::filesystem::is_character_file("/dev/null"));
}

TEST_CASE("AFileThatIsReplacedKeepsItsPermissions") {
  const ScratchDirectory scratch;
  const auto permissions_of = [&] {
    struct stat facts {};
    REQUIRE(::stat((scratch / "mesh.ply").c_str(), &facts) == 0);
    return facts.st_mode & 0777U;
  };
  const auto write = [&] {
    AtomicFile file(scratch / "mesh.ply");
    file.write("private");
    file.commit();
  };
  write();
  const auto mask = ::umask(0);
  ::umask(mask);
  CHECK(permissions_of() == (0666U & ~mask));
  for (const mode_t mode : {0600U, 0664U}) {
    REQUIRE(::chmod((scratch / "mesh.ply").c_str(), mode) == 0);
    write();
    CHECK(permissions_of() == mode);
  }
}

TEST_CASE("IndicesAreAsWideAsTheVerticesNeed") {
  struct Case {
    std::uint64_t vertices;
    std::string type;
    std::size_t row_bytes;
  };
  for (const Case& c : {Case{1'000'000, "int", 13}, Case{2'147'483'647, "int", 13},
                        Case{3'000'000'000, "uint", 13}, Case{4'294'967'296, "uint", 13},
                        Case{4'294'967'297, "int64", 25}, Case{5'000'000'000'000, "int64", 25}}) {
    MeshHeader header;
    header.vertices = c.vertices;
    header.triangles = 2 * c.vertices;
    const auto rows = mesh_rows("a.ply", header);
    REQUIRE(rows != nullptr);
    INFO(c.vertices);
    CHECK_THAT(rows->front({}), Contains("element vertex " + std::to_string(c.vertices) + "\n"));
    CHECK_THAT(rows->front({}), Contains("element face " + std::to_string(2 * c.vertices) + "\n"));
    CHECK_THAT(rows->front({}), Contains("property list uchar " + c.type + " vertex_indices\n"));
    CHECK(rows->vertex_bytes() == 24);
    CHECK(rows->triangle_bytes() == c.row_bytes);
  }
}

/// Rows of a mesh of that many vertices, put where they belong in a sparse file, and read back.
void require_rows_read_back(std::uint64_t vertices) {
  const ScratchDirectory scratch;
  MeshHeader header;
  header.vertices = vertices;
  header.triangles = 2 * vertices;
  header.has_hole = true;
  const auto rows = mesh_rows(scratch / "a.ply", header);
  const std::vector<Triangle64> triangles = {{vertices - 1, 0, vertices / 2},
                                             {7, vertices - 2, vertices - 1}};
  const std::vector<std::int32_t> hole = {0, 41};
  const std::uint64_t offset = rows->front({}).size() + vertices * rows->vertex_bytes();
  test::write_file(scratch / "a.ply", rows->front({}));
  {
    PlacedFile file(scratch / "a.ply", scratch / "a.ply");
    PlacedBuffer buffer;
    rows->put_triangles(triangles, hole, buffer.place(offset, 2 * rows->triangle_bytes()));
    file.write(buffer);
    file.flush();
  }
  CHECK(std::filesystem::file_size(scratch / "a.ply") == offset + 2 * rows->triangle_bytes());

  ByteReader front(open_byte_source(scratch / "a.ply"));
  const PlyHeader read = read_ply_header(front);
  CHECK(read.find("vertex")->count == vertices);
  PlyElement faces = *read.find("face");
  CHECK(faces.count == 2 * vertices);
  faces.count = 2;
  std::ifstream stream(scratch / "a.ply", std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(offset));
  std::string bytes(2 * rows->triangle_bytes(), ' ');
  REQUIRE(stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size())));
  test::write_file(scratch / "rows", bytes);
  ByteReader reader(open_byte_source(scratch / "rows"));
  PlyRowReader parser(reader, read, faces, find_corner_list(faces));
  std::vector<std::uint64_t> corners;
  while (parser.next(10) != 0) {
    for (const std::int64_t corner : parser.list_values())
      corners.push_back(static_cast<std::uint64_t>(corner));
  }
  CHECK(corners ==
        std::vector<std::uint64_t>{vertices - 1, 0, vertices / 2, 7, vertices - 2, vertices - 1});
}

TEST_CASE("MeshesBeyond32BitReadBack") {
  require_rows_read_back(1'000);
  require_rows_read_back(3'000'000'000);  // rows beyond 64 GiB
  require_rows_read_back(5'000'000'000);
}

TEST_CASE("PlacedPiecesMakeTheWholeFile") {
  const ScratchDirectory scratch;
  // Long enough for whole pages to go past the page cache, and cut anywhere.
  std::string expected;
  for (std::size_t i = 0; i < 3'000'000; ++i)
    expected += static_cast<char>((i * 2654435761u) >> 13);
  const std::vector<std::size_t> cuts = {0,         1,         4096,      70'001,
                                         1'000'000, 1'004'096, 2'999'999, expected.size()};
  test::write_file(scratch / "a", "");
  {
    PlacedFile file(scratch / "a", "a");
    file.reserve(expected.size());
    CHECK(std::filesystem::file_size(scratch / "a") == expected.size());
    WriteBehind writer(file, 3);
    for (std::size_t i = cuts.size() - 1; i-- > 0;) {
      auto buffer = writer.take();
      const std::size_t bytes = cuts[i + 1] - cuts[i];
      std::memcpy(buffer->place(cuts[i], bytes), expected.data() + cuts[i], bytes);
      writer.give(std::move(buffer));
    }
    writer.finish();
    file.flush();
  }
  CHECK((read_file(scratch / "a") == expected));
}

TEST_CASE("AFailingWriteReachesWhoeverWaitsForIt") {
  const ScratchDirectory scratch;
  test::write_file(scratch / "a", "");
  PlacedFile file(scratch / "a", "mesh.ply");
  rlimit old{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &old) == 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = old;
  small.rlim_cur = 100'000;
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  std::string message;
  ErrorKind status = ErrorKind::kNone;
  try {
    WriteBehind writer(file, 2);
    for (std::uint64_t i = 0; i < 10; ++i) {
      auto buffer = writer.take();
      std::memset(buffer->place(i * 100'000, 100'000), 1, 100'000);
      writer.give(std::move(buffer));
    }
    writer.finish();
  } catch (const Error& error) {
    status = error.kind();
    message = error.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &old);
  std::signal(SIGXFSZ, handler);
  CHECK(status == ErrorKind::kResource);
  CHECK_THAT(message, Contains("mesh.ply"));
}

TEST_CASE("BinaryStlBeyondItsLimitIsAUsageErrorBeforeAnyFile") {
  const ScratchDirectory scratch;
  MeshHeader header;
  header.vertices = 2'200'000'000;
  header.triangles = 4'294'967'296;
  try {
    open_mesh_writer(scratch / "a.stl", header);
    FAIL("opened");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    CHECK_THAT(error.what(), Contains("4294967296"));
  }
  CHECK(files_in(scratch.path()) == 0);
  CHECK_THROWS_AS(check_mesh_size(scratch / "a.stl", header, {}), Error);
  header.triangles = 4'294'967'295;
  CHECK_NOTHROW(check_mesh_size(scratch / "a.stl", header, {}));
  header.triangles = 1ull << 40;
  MeshWriterOptions text;
  text.binary = false;
  CHECK_NOTHROW(check_mesh_size(scratch / "a.stl", header, text));
  CHECK_NOTHROW(check_mesh_size(scratch / "a.ply", header, {}));
  CHECK_NOTHROW(check_mesh_size(scratch / "a.obj", header, {}));
}

TEST_CASE("ObjNamesVerticesBeyond32Bit") {
  const ScratchDirectory scratch;
  MeshHeader header;
  header.vertices = 5'000'000'000;
  header.triangles = 1;
  const auto writer = open_mesh_writer(scratch / "a.obj", header);
  const Triangle64 triangle = {4'999'999'999, 4'294'967'296, 0};
  const auto bytes = writer->encode_triangles(std::span(&triangle, 1), {});
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  CHECK(text == "f 5000000000 4294967297 1\n");
}

}  // namespace orbweave
