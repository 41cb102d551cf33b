#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/shift_file.h"
#include "tests/io/glb_file.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Catch::Contains;
using test::GlbFile;
using test::ScratchDirectory;

/// With normals, colours of 8 bits and one attribute more.
TriangleMesh painted_mesh() {
  TriangleMesh mesh;
  mesh.vertices.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.1, 0.2, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  mesh.vertices.schema.has_normals = true;
  mesh.vertices.schema.attributes = {{"red", ScalarType::kUint8},
                                     {"green", ScalarType::kUint8},
                                     {"intensity", ScalarType::kUint8},
                                     {"blue", ScalarType::kUint8}};
  mesh.vertices.normals = {{0, 0, -2}, {1, 0, 0}, {0, 0, 0}, {0, 3, 4}};
  for (int i = 0; i < 16; ++i) mesh.vertices.attributes.push_back(static_cast<std::byte>(16 * i));
  return mesh;
}

std::uint8_t srgb_byte(std::uint16_t linear) {
  const double l = linear / 65535.0;
  const double s = l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * s));
}

std::string refusal(const std::filesystem::path& path, const MeshHeader& header) {
  try {
    open_mesh_writer(path, header);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kUsage);
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("GlbHasVerticesTrianglesAndTheirBounds") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = painted_mesh();
  write_mesh(scratch / "a.glb", mesh);
  const GlbFile glb(scratch / "a.glb");
  CHECK(glb.triangles() == mesh.triangles);
  const auto& positions = glb.accessor("POSITION");
  REQUIRE(positions.at("count") == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto p = glb.element<float, 3>(positions, i);
    for (int axis = 0; axis < 3; ++axis)
      CHECK(p[static_cast<std::size_t>(axis)] ==
            static_cast<float>(mesh.vertices.positions[i][axis]));
  }
  CHECK(positions.at("min") == std::vector<double>{0, 0, 0});
  CHECK(positions.at("max") == std::vector<double>{1, 1, 1});
}

TEST_CASE("GlbBoundsAreThoseOfTheFloats") {
  const ScratchDirectory scratch;
  TriangleMesh mesh = painted_mesh();
  for (Vec3& p : mesh.vertices.positions) p = p + Vec3{0.1, -0.3, 1.0 / 3.0};
  MeshWriterOptions options;
  options.origin = {0.7, 0.0, 0.0};
  write_mesh(scratch / "a.glb", mesh, options);
  const GlbFile glb(scratch / "a.glb");
  const auto& positions = glb.accessor("POSITION");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double least = 1e9;
    double most = -1e9;
    for (std::size_t i = 0; i < 4; ++i) {
      const double value = glb.element<float, 3>(positions, i)[axis];
      least = std::min(least, value);
      most = std::max(most, value);
    }
    CHECK(positions.at("min").at(axis).get<double>() == least);
    CHECK(positions.at("max").at(axis).get<double>() == most);
  }
}

TEST_CASE("GlbNormalsAreOfUnitLength") {
  const ScratchDirectory scratch;
  write_mesh(scratch / "a.glb", painted_mesh());
  const GlbFile glb(scratch / "a.glb");
  const auto& normals = glb.accessor("NORMAL");
  using Normal = std::array<float, 3>;
  CHECK(glb.element<float, 3>(normals, 0) == Normal{0.0F, 0.0F, -1.0F});
  CHECK(glb.element<float, 3>(normals, 2) == Normal{0.0F, 0.0F, 1.0F});
  CHECK(glb.element<float, 3>(normals, 3) == Normal{0.0F, 0.6F, 0.8F});
}

TEST_CASE("GlbColorsAreLinearAndGiveTheirBytesBack") {
  const ScratchDirectory scratch;
  TriangleMesh mesh;
  mesh.vertices.schema.attributes = {
      {"red", ScalarType::kUint8}, {"green", ScalarType::kUint8}, {"blue", ScalarType::kUint8}};
  for (int i = 0; i < 256; ++i) {
    mesh.vertices.positions.push_back({static_cast<double>(i), 0.0, static_cast<double>(i % 2)});
    for (int c = 0; c < 3; ++c) mesh.vertices.attributes.push_back(static_cast<std::byte>(i));
  }
  mesh.triangles = {{0, 1, 2}};
  write_mesh(scratch / "a.glb", mesh);
  const GlbFile glb(scratch / "a.glb");
  const auto& colors = glb.accessor("COLOR_0");
  CHECK(colors.at("normalized") == true);
  for (std::size_t i = 0; i < 256; ++i) {
    const auto color = glb.element<std::uint16_t, 4>(colors, i);
    CHECK(srgb_byte(color[0]) == i);
    CHECK(color[3] == 65535);
  }
  // Half the light is not half the number.
  CHECK(glb.element<std::uint16_t, 4>(colors, 128)[0] == 14146);
}

TEST_CASE("GlbNamesTheAttributesItLeavesOut") {
  const ScratchDirectory scratch;
  TriangleMesh mesh = painted_mesh();
  write_mesh(scratch / "a.glb", mesh);
  using Names = std::vector<std::string>;
  const auto left_out = [](const GlbFile& glb) {
    return glb.json.at("meshes").at(0).at("extras").at("attributes_left_out");
  };
  CHECK(left_out(GlbFile(scratch / "a.glb")) == Names{"intensity"});
  CHECK(columns_without_place("a.glb", mesh.vertices.schema) == Names{"intensity"});
  mesh.vertices.schema.attributes[1].name = "grey";
  write_mesh(scratch / "b.glb", mesh);
  const GlbFile colorless(scratch / "b.glb");
  CHECK(left_out(colorless) == Names{"red", "grey", "intensity", "blue"});
  CHECK_FALSE(colorless.has("COLOR_0"));
}

TEST_CASE("GlbNodeTurnsTheUprightAxisToYAndMovesTheOriginToItsPlace") {
  const ScratchDirectory scratch;
  TriangleMesh mesh = painted_mesh();
  const Vec3 far{4176000.0, -512000.0, 250.0};
  for (Vec3& p : mesh.vertices.positions) p = p + far;
  MeshWriterOptions options;
  options.origin = far;
  for (int up = 0; up < 3; ++up) {
    options.up_axis = up;
    write_mesh(scratch / "a.glb", mesh, options);
    const std::vector<Vec3> seen = GlbFile(scratch / "a.glb").seen_positions();
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Vec3 p = mesh.vertices.positions[i];
      const Vec3 expected = up == 0 ? Vec3{-p.y, p.x, p.z} : up == 1 ? p : Vec3{p.x, p.z, -p.y};
      CHECK(norm(seen[i] - expected) < 1e-6);
    }
  }
}

TEST_CASE("GlbNeedsNoFileForItsShift") {
  CHECK(shift_file("a.glb").empty());
  CHECK_FALSE(shift_file("a.stl").empty());
}

TEST_CASE("GlbRowsAreTheBytesOfTheWriter") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = painted_mesh();
  write_mesh(scratch / "a.glb", mesh);
  MeshHeader header;
  header.vertices = 4;
  header.triangles = 4;
  header.schema = mesh.vertices.schema;
  const auto rows = mesh_rows("a.glb", header);
  REQUIRE(rows != nullptr);
  std::string bytes = rows->front(mesh.vertices.bounds());
  CHECK(bytes.size() == rows->front({}).size());
  const std::size_t front = bytes.size();
  bytes.resize(front + 4 * rows->vertex_bytes() + 4 * rows->triangle_bytes());
  rows->put_vertices(mesh.vertices, reinterpret_cast<std::byte*>(bytes.data() + front));
  std::vector<Triangle64> triangles;
  for (const Triangle& t : mesh.triangles) triangles.push_back({t[0], t[1], t[2]});
  rows->put_triangles(
      triangles, {}, reinterpret_cast<std::byte*>(bytes.data() + front + 4 * rows->vertex_bytes()));
  CHECK(bytes == test::read_file(scratch / "a.glb"));
}

TEST_CASE("GlbBeyondFourGigabytesIsRefusedBeforeAnyFile") {
  const ScratchDirectory scratch;
  MeshHeader header;
  header.vertices = 120'000'000;
  header.triangles = 240'000'000;
  const std::string message = refusal(scratch / "a.glb", header);
  CHECK_THAT(message,
             Contains("240000000 triangles") && Contains("4294967295 bytes") && Contains(".ply"));
  CHECK(std::filesystem::is_empty(scratch.path()));
  header.vertices = 100'000'000;
  header.triangles = 200'000'000;
  CHECK_NOTHROW(check_mesh_size("a.glb", header, {}));
}

TEST_CASE("GlbIsNotWrittenToAPipe") {
  const ScratchDirectory scratch;
  REQUIRE(::mkfifo((scratch / "a.glb").c_str(), 0600) == 0);
  CHECK_THAT(refusal(scratch / "a.glb", {}), Contains("a.glb") && Contains("regular file"));
}

TEST_CASE("UnfinishedGlbLeavesNothingBehind") {
  const ScratchDirectory scratch;
  {
    MeshHeader header;
    header.vertices = 10;
    const auto writer = open_mesh_writer(scratch / "a.glb", header);
  }
  CHECK(std::filesystem::is_empty(scratch.path()));
}

}  // namespace orbweave
