// Meshes read from GLB: what the writer wrote, scenes of other programs, and what is refused.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_stream.h"
#include "io/meshes/mesh_writer.h"
#include "tests/io/reading.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

using Catch::Contains;
using Json = nlohmann::json;
using test::ScratchDirectory;

template <class T>
void append(std::string& bytes, const std::vector<T>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

/// The bytes of a GLB file with this document and these data.
std::string glb_bytes(const Json& json, const std::string& data) {
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string bytes;
  append<std::uint32_t>(bytes,
                        {0x46546C67, 2, static_cast<std::uint32_t>(28 + text.size() + data.size()),
                         static_cast<std::uint32_t>(text.size()), 0x4E4F534A});
  bytes += text;
  append<std::uint32_t>(bytes, {static_cast<std::uint32_t>(data.size()), 0x004E4942});
  return bytes + data;
}

/// One triangle of another program: floats, then indices of 16 bits.
struct OneTriangle {
  OneTriangle() {
    append<float>(data, {0, 0, 0, 1, 0, 0, 0, 2, 0});
    append<std::uint16_t>(data, {0, 1, 2, 0});
    json = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
      "nodes": [{"mesh": 0}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
                    {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
      "bufferViews": [{"buffer": 0, "byteLength": 36},
                      {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
      "buffers": [{"byteLength": 44}]})");
  }
  Json& primitive() { return json["meshes"][0]["primitives"][0]; }
  TriangleMesh read() const {
    const ScratchDirectory scratch;
    std::ofstream(scratch / "a.glb", std::ios::binary) << glb_bytes(json, data);
    return read_mesh(scratch / "a.glb");
  }
  /// What the refusal says; it names the file.
  std::string refusal() const {
    try {
      read();
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kBadInput);
      CHECK_THAT(error.what(), Contains("a.glb"));
      return error.what();
    }
    return "";
  }

  Json json;
  std::string data;
};

/// Coordinates that floats hold, normals of unit length, colours and tags.
TriangleMesh tagged_mesh() {
  TriangleMesh mesh;
  mesh.vertices.positions = {{0, 0, 0}, {1, 0, 0.5}, {0, 1, -0.25}, {0.125, 0.25, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  mesh.vertices.schema.has_normals = true;
  mesh.vertices.normals = {{0, 0, -1}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  mesh.vertices.schema.attributes = {{"red", ScalarType::kUint8},
                                     {"green", ScalarType::kUint8},
                                     {"blue", ScalarType::kUint8},
                                     {"confidence", ScalarType::kFloat32},
                                     {"hole", ScalarType::kFloat32}};
  for (int i = 0; i < 4; ++i) {
    for (int c = 0; c < 3; ++c)
      mesh.vertices.attributes.push_back(static_cast<std::byte>(80 * c + i));
    for (const float tag : {0.25F * static_cast<float>(i), i < 3 ? 7.0F : 0.0F}) {
      const auto* from = reinterpret_cast<const std::byte*>(&tag);
      mesh.vertices.attributes.insert(mesh.vertices.attributes.end(), from, from + sizeof tag);
    }
  }
  return mesh;
}

void expect_refusal(const OneTriangle& file, const char* problem, const char* place) {
  CHECK_THAT(file.refusal(), Contains(problem) && Contains(place));
}

}  // namespace

TEST_CASE("AGlbFileGivesBackWhatWasWritten") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = tagged_mesh();
  MeshWriterOptions options;
  options.glb_attributes = {"hole", "confidence"};
  options.up_axis = GENERATE(0, 1, 2);
  options.origin = GENERATE(Vec3{}, Vec3{512'340, -4'176'135, 64});
  TriangleMesh moved = mesh;
  for (Vec3& position : moved.vertices.positions) position = position + options.origin;
  write_mesh(scratch / "a.glb", moved, options);
  CHECK(holds_faces(scratch / "a.glb"));
  const TriangleMesh read = read_mesh(scratch / "a.glb");
  CHECK((read.vertices.positions == moved.vertices.positions));
  CHECK((read.vertices.normals == mesh.vertices.normals));
  CHECK((read.vertices.attributes == mesh.vertices.attributes));
  CHECK((read.vertices.schema.attributes == mesh.vertices.schema.attributes));
  CHECK(read.triangles == mesh.triangles);
  CHECK(read.hole == std::vector<std::int32_t>{7, 0, 0, 0});
  CHECK(open_mesh_stream(scratch / "a.glb")->faces() == 4);
}

TEST_CASE("NodesPlaceTheirMeshes") {
  OneTriangle file;
  // The parent moves what its child turns by a right angle about z and stretches.
  file.json["nodes"] = Json::parse(R"([{"children": [1], "translation": [100, 0, 0]},
    {"mesh": 0, "rotation": [0, 0, 1, 1], "scale": [3, 1, 1]}])");
  const double half = std::sqrt(0.5);
  file.json["nodes"][1]["rotation"] = {0, 0, half, half};
  const TriangleMesh turned = file.read();
  const std::vector<Vec3> expected = {{100, 0, 0}, {100, 3, 0}, {98, 0, 0}};
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(norm(turned.vertices.positions[i] - expected[i]) < 1e-13 * norm(expected[i]));
  CHECK(turned.triangles == std::vector<Triangle>{{0, 1, 2}});
  CHECK(turned.vertices.schema.position_type == ScalarType::kFloat64);

  // A mirror shows the other side.
  file.json["nodes"] =
      Json::parse(R"([{"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]}])");
  const TriangleMesh mirrored = file.read();
  CHECK((mirrored.vertices.positions == std::vector<Vec3>{{0, 0, 5}, {-1, 0, 5}, {0, 2, 5}}));
  CHECK(mirrored.triangles == std::vector<Triangle>{{0, 2, 1}});
}

TEST_CASE("MeshesOfOtherProgramsAreRead") {
  OneTriangle file;
  SECTION("as they are") {
    const TriangleMesh mesh = file.read();
    CHECK((mesh.vertices.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}}));
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}});
    CHECK(mesh.vertices.schema.position_type == ScalarType::kFloat32);
  }
  SECTION("without indices") {
    file.primitive().erase("indices");
    CHECK(file.read().triangles == std::vector<Triangle>{{0, 1, 2}});
  }
  SECTION("without a scene") {
    file.json.erase("scene");
    file.json.erase("scenes");
    file.json["nodes"] =
        Json::parse(R"([{"mesh": 0}, {"children": [0], "translation": [1, 0, 0]}])");
    CHECK(file.read().vertices.positions[0] == Vec3{1, 0, 0});
  }
  SECTION("with materials in several lists over the same vertices") {
    file.json["meshes"][0]["primitives"].push_back(file.primitive());
    const TriangleMesh mesh = file.read();
    CHECK(mesh.vertices.size() == 3);
    CHECK(mesh.triangles.size() == 2);
  }
  SECTION("shown by two nodes") {
    file.json["scenes"][0]["nodes"] = {0, 1};
    file.json["nodes"].push_back(Json::parse(R"({"mesh": 0, "translation": [0, 0, 9]})"));
    const TriangleMesh mesh = file.read();
    REQUIRE(mesh.vertices.size() == 6);
    CHECK(mesh.triangles[1] == Triangle{3, 4, 5});
    CHECK(mesh.vertices.positions[5] == Vec3{0, 2, 9});
  }
  SECTION("quantized, with an extension of materials") {
    file.json["extensionsRequired"] = {"KHR_mesh_quantization", "KHR_materials_unlit"};
    file.data.clear();
    append<std::int16_t>(file.data, {0, 0, 0, 0, 32767, 0, 0, 0, 0, -32767, 0, 0});
    append<std::uint16_t>(file.data, {0, 1, 2, 0});
    file.json["accessors"][0] = {{"bufferView", 0},
                                 {"componentType", 5122},
                                 {"count", 3},
                                 {"type", "VEC3"},
                                 {"normalized", true}};
    file.json["bufferViews"][0] = {{"buffer", 0}, {"byteLength", 24}, {"byteStride", 8}};
    file.json["bufferViews"][1]["byteOffset"] = 24;
    CHECK((file.read().vertices.positions == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, -1, 0}}));
  }
}

TEST_CASE("AGltfFileIsReadWithItsDataInsideOrBeside") {
  const ScratchDirectory scratch;
  OneTriangle file;
  const TriangleMesh expected = file.read();
  const auto read_as = [&](const char* name, const std::string& bytes) {
    std::ofstream(scratch / name, std::ios::binary) << bytes;
    const TriangleMesh mesh = read_mesh(scratch / name);
    CHECK((mesh.vertices.positions == expected.vertices.positions));
    CHECK(mesh.triangles == expected.triangles);
    CHECK(holds_faces(scratch / name));
  };
  std::ofstream(scratch / "the data.bin", std::ios::binary) << file.data;
  file.json["buffers"][0]["uri"] = "the data.bin";
  read_as("beside.gltf", file.json.dump(1));
  // As exporters write other characters than letters and digits.
  for (const char* uri : {"the%20data.bin", "./the%20data.bin", "%74he data%2Ebin"}) {
    file.json["buffers"][0]["uri"] = uri;
    read_as("beside.gltf", file.json.dump(1));
  }
  std::ofstream(scratch / "100%_\xC3\xA9#?.bin", std::ios::binary) << file.data;
  file.json["buffers"][0]["uri"] = "100%25_%c3%A9%23%3F.bin";
  read_as("beside.gltf", file.json.dump(1));
  // The 44 bytes: floats 1 and 2 are 0000803f and 00000040.
  file.json["buffers"][0]["uri"] =
      "data:application/octet-stream;base64,"
      "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAAAAABAAIAAAA=";
  read_as("inside.gltf", file.json.dump(1));
  read_as("inside.glb", glb_bytes(file.json, ""));  // as Open3D writes it
}

TEST_CASE("WhatAGlbReaderDoesNotKnowIsRefusedByPlace") {
  OneTriangle file;
  SECTION("required extension") {
    file.json["extensionsRequired"] = {"EXT_meshopt_compression"};
    expect_refusal(file, "EXT_meshopt_compression", "extensionsRequired");
  }
  SECTION("sparse accessor") {
    file.json["accessors"][0]["sparse"] = Json::object();
    expect_refusal(file, "sparse numbers", "accessors[0]");
  }
  SECTION("morph target") {
    file.primitive()["targets"] = Json::array();
    expect_refusal(file, "morph targets", "meshes[0].primitives[0]");
  }
  SECTION("skin") {
    file.json["nodes"][0]["skin"] = 0;
    expect_refusal(file, "moving surfaces", "nodes[0]");
  }
  SECTION("glTF 1.0") {
    file.json["asset"]["version"] = "1.0";
    expect_refusal(file, "\"1.0\"", "asset");
  }
  SECTION("lines") {
    file.primitive()["mode"] = 1;
    expect_refusal(file, "mode 1", "meshes[0].primitives[0]");
  }
  SECTION("file outside of the folder") {
    const char* uri = GENERATE("../a.bin", "/etc/hostname", "http://a/b.bin", "%2e%2e/a.bin", "",
                               "..%2fa.bin", "%2fetc%2fhostname", "./%2e.", "a%5cb.bin", "a%00.bin",
                               "a%2", "a%zz.bin", "a%+1.bin", "./");
    file.json["buffers"][0]["uri"] = uri;
    expect_refusal(file, "a file in its folder", "buffers[0]");
  }
  SECTION("data that are no base64") {
    file.json["buffers"][0]["uri"] = "data:application/octet-stream;base64,AA*A";
    expect_refusal(file, "character 2", "buffers[0]");
  }
  SECTION("buffer that is nowhere") {
    file.json["buffers"].push_back(Json::object());
    file.json["bufferViews"][0]["buffer"] = 1;
    expect_refusal(file, "a buffer that is nowhere", "bufferViews[0]");
  }
}

TEST_CASE("NumbersOfAGlbThatDoNotFitEachOtherAreRefusedByPlace") {
  OneTriangle file;
  SECTION("vertex that is not there") {
    file.json["accessors"][0]["count"] = 2;
    expect_refusal(file, "vertex 2", "triangle 0");
  }
  SECTION("numbers beyond their view") {
    file.json["accessors"][0]["count"] = 4;
    expect_refusal(file, "beyond their buffer view", "accessors[0]");
  }
  SECTION("stride that overflows") {
    file.json["accessors"][0]["count"] = 281474976710656;
    file.json["bufferViews"][0]["byteStride"] = 281474976710656;
    expect_refusal(file, "beyond their buffer view", "accessors[0]");
  }
  SECTION("view beyond the data") {
    file.json["bufferViews"][1]["byteLength"] = 1000;
    expect_refusal(file, "longer than the data", "bufferViews[1]");
  }
  SECTION("node in a circle") {
    file.json["nodes"][0]["children"] = {0};
    expect_refusal(file, "in the scene twice", "nodes[0]");
  }
  SECTION("index of nothing") {
    file.json["nodes"][0]["mesh"] = 3;
    expect_refusal(file, "meshes[3]", "nodes[0]");
  }
  SECTION("corners that are no triangles") {
    file.json["accessors"][1]["count"] = 2;
    expect_refusal(file, "not those of triangles", "meshes[0].primitives[0]");
  }
  SECTION("colours of another length") {
    file.primitive()["attributes"]["COLOR_0"] = 1;
    expect_refusal(file, "colours", "accessors[1]");
  }
  SECTION("matrix with a perspective") {
    file.json["nodes"][0]["matrix"] = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    expect_refusal(file, "no affine map", "nodes[0].matrix");
  }
}

TEST_CASE("ASceneOfManyInstancesDoesNotFillTheMemory") {
  OneTriangle file;
  Json nodes = Json::array();
  for (int i = 0; i < 1000; ++i) {
    file.json["nodes"][static_cast<std::size_t>(i)] = {{"mesh", 0}};
    nodes.push_back(i);
  }
  file.json["scenes"][0]["nodes"] = nodes;
  CHECK_THAT(file.refusal(), Contains("too large for its file"));
}

TEST_CASE("AGltfDocumentThatIsNestedTooDeeplyIsRefused") {
  const ScratchDirectory scratch;
  OneTriangle file;
  std::ofstream(scratch / "a.bin", std::ios::binary) << file.data;
  file.json["buffers"][0]["uri"] = "a.bin";
  constexpr std::size_t kLevels = 200'000;
  const std::string deep = std::string(kLevels, '[') + std::string(kLevels, ']');
  const auto place = GENERATE(as<Json::json_pointer>(), "/asset/generator"_json_pointer,
                              "/meshes/0/primitives/0/attributes/_A"_json_pointer,
                              "/accessors/0/normalized"_json_pointer);
  file.json[place] = "deep";
  std::string text = file.json.dump();
  text.replace(text.find("\"deep\""), 6, deep);
  std::ofstream(scratch / "a.gltf") << text;
  CHECK_THROWS_WITH(read_mesh(scratch / "a.gltf"),
                    Contains("a.gltf") && Contains("nested too deeply"));
}

TEST_CASE("AGlbFileThatEndsEarlyIsRefused") {
  const ScratchDirectory scratch;
  const OneTriangle file;
  const std::string whole = glb_bytes(file.json, file.data);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    std::ofstream(scratch / "a.glb", std::ios::binary) << whole.substr(0, length);
    INFO(length << " bytes of " << whole.size());
    REQUIRE_THROWS_AS(read_mesh(scratch / "a.glb"), Error);
  }
}

TEST_CASE("GlbFilesAreReadFromGzipAndListedSo") {
  const ScratchDirectory scratch;
  const OneTriangle file;
  test::gzip_file(scratch / "a.glb.gz", glb_bytes(file.json, file.data));
  CHECK(read_mesh(scratch / "a.glb.gz").triangles.size() == 1);
  std::ofstream(scratch / "a.off") << "OFF";
  CHECK_THROWS_WITH(read_mesh(scratch / "a.off"), Contains(".glb[.gz] or .gltf[.gz]"));
}

TEST_CASE("AGlbFileThatGoesOnBehindItsEndIsRefused") {
  const ScratchDirectory scratch;
  const OneTriangle file;
  const std::string whole = glb_bytes(file.json, file.data);
  std::ofstream(scratch / "a.glb", std::ios::binary) << whole << '\0';
  CHECK_THROWS_WITH(
      read_mesh(scratch / "a.glb"),
      Contains("goes on after its end") && Contains("byte " + std::to_string(whole.size())));
}

}  // namespace orbweave
