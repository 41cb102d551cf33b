// Compressed tiles: what readers of EXT_meshopt_compression find in them.
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/levels/tileset.h"
#include "engine/levels/tileset_work.h"
#include "io/meshes/mesh_stream.h"
#include "io/meshes/mesh_writer.h"
#include "tests/io/glb_file.h"
#include "tests/support/data.h"
#include "tests/support/folder_files.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::GlbFile;
using test::ScratchDirectory;

constexpr const char* kExtension = "EXT_meshopt_compression";

/// With all that tiles can hold: normals, colours, patches, two components.
void write_full_mesh(const fs::path& file) {
  const TriangleMesh torus = test::moved(test::torus_mesh(4000), [](Vec3 p) {
    return (1.0 + 0.02 * std::sin(9.0 * p.x) * std::cos(11.0 * p.y)) * p;
  });
  const TriangleMesh sphere = test::moved(test::sphere_mesh(3), [](Vec3 p) {
    return 0.25 * p + Vec3{0.0, 0.0, 3.0};
  });
  TriangleMesh mesh = test::joined(torus, sphere);
  PointCloud& vertices = mesh.vertices;
  vertices.schema.has_normals = true;
  vertices.schema.attributes = {
      {"red", ScalarType::kUint8}, {"green", ScalarType::kUint8}, {"blue", ScalarType::kUint8}};
  for (const Vec3& p : vertices.positions) {
    vertices.normals.push_back(normalized(p));
    for (const double c : {p.x, p.y, p.z})
      vertices.attributes.push_back(static_cast<std::byte>(std::lround(40.0 * (c + 3.0))));
  }
  const auto is_filled = [&](const Triangle& t) { return vertices.positions[t[0]].x > 1.0; };
  std::stable_partition(mesh.triangles.begin(), mesh.triangles.end(), std::not_fn(is_filled));
  for (const Triangle& t : mesh.triangles) mesh.hole.push_back(is_filled(t) ? 1 : 0);
  MeshWriterOptions options;
  options.has_confidence = true;
  options.confidence = {0.5F};
  write_mesh(file, mesh, options);
}

TilesetFacts tiles_of(const ScratchDirectory& in, const std::string& name,
                      TileCompression compression, int threads = 1) {
  TilesetOptions options;
  options.compression = compression;
  options.levels.leaf_triangles = 700;
  options.levels.threads = threads;
  options.levels.directory = in / (name + ".work");
  const TilesetWork work(options.levels.directory);
  const StopToken stop;
  return write_tileset(*open_mesh_stream(in / "mesh.ply"), in / name, options, {}, stop);
}

/// The bytes of a view, decoded by the library that the extension's codecs are of.
std::string decoded(const GlbFile& glb, const json& view) {
  const json& packed = view.at("extensions").at(kExtension);
  CHECK(packed.at("buffer") == 0);
  CHECK(view.at("buffer") == 1);
  CHECK(view.at("byteLength") ==
        packed.at("count").get<std::size_t>() * packed.at("byteStride").get<std::size_t>());
  const std::size_t at = packed.value("byteOffset", std::size_t{0}),
                    bytes = packed.at("byteLength");
  const std::size_t count = packed.at("count"), stride = packed.at("byteStride");
  REQUIRE(at + bytes <= glb.bin.size());
  const auto* source = reinterpret_cast<const unsigned char*>(glb.bin.data()) + at;
  std::string rows(count * stride, '\0');
  const bool is_vertices = packed.at("mode") == "ATTRIBUTES";
  const int failure = is_vertices
                          ? meshopt_decodeVertexBuffer(rows.data(), count, stride, source, bytes)
                          : meshopt_decodeIndexBuffer(rows.data(), count, stride, source, bytes);
  REQUIRE(failure == 0);
  return rows;
}

/// The file as it would be without compression.
GlbFile unpacked(const fs::path& path) {
  GlbFile glb(path);
  CHECK(glb.json.at("extensionsRequired") == json({kExtension}));
  CHECK(glb.json.at("extensionsUsed") == json({kExtension}));
  REQUIRE(glb.json.at("bufferViews").size() == 2);
  std::string bin;
  for (json& view : glb.json.at("bufferViews")) {
    const std::string rows = decoded(glb, view);
    CHECK(view.value("byteOffset", std::size_t{0}) == bin.size());
    bin += rows;
    view["buffer"] = 0;
    view.erase("extensions");
  }
  CHECK(glb.json.at("buffers").at(1).at("byteLength") == bin.size());
  glb.json.erase("extensionsRequired");
  glb.json.erase("extensionsUsed");
  glb.json["buffers"] = json::array({{{"byteLength", bin.size()}}});
  glb.bin = bin;
  return glb;
}

/// Rows of vertices and triangles by these rows, whatever their order and their first corners.
struct TileContent {
  std::vector<std::string> vertices;
  std::vector<std::array<std::string, 3>> triangles;
  bool operator==(const TileContent&) const = default;
};

TileContent content_of(const GlbFile& glb) {
  const std::size_t stride = glb.json.at("bufferViews").at(0).at("byteStride");
  TileContent content;
  for (std::size_t at = 0; at < glb.json.at("bufferViews").at(0).at("byteLength"); at += stride)
    content.vertices.push_back(glb.bin.substr(at, stride));
  for (const Triangle& t : glb.triangles()) {
    std::array<std::string, 3> corners = {content.vertices.at(t[0]), content.vertices.at(t[1]),
                                          content.vertices.at(t[2])};
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    content.triangles.push_back(corners);
  }
  std::sort(content.vertices.begin(), content.vertices.end());
  std::sort(content.triangles.begin(), content.triangles.end());
  return content;
}

}  // namespace

TEST_CASE("EveryCompressedTileHoldsBitByBitWhatTheTileWithoutCompressionHolds") {
  const ScratchDirectory in;
  write_full_mesh(in / "mesh.ply");
  const TilesetFacts plain = tiles_of(in, "plain", TileCompression::kNone);
  const TilesetFacts packed = tiles_of(in, "packed", TileCompression::kMeshopt);
  REQUIRE(plain.levels.size() > 2);
  CHECK(packed.bytes < plain.bytes * 3 / 4);
  CHECK(test::read_file(in / "packed" / kTilesetName) ==
        test::read_file(in / "plain" / kTilesetName));
  std::size_t tiles = 0;
  for (const auto& entry : fs::directory_iterator(in / "plain")) {
    if (entry.path().extension() != ".glb") continue;
    INFO(entry.path());
    const GlbFile before(entry.path());
    const GlbFile after = unpacked(in / "packed" / entry.path().filename().string());
    CHECK(after.json == before.json);
    CHECK((content_of(after) == content_of(before)));
    ++tiles;
  }
  CHECK(tiles == plain.tiles);
}

TEST_CASE("CompressedTilesetIsTheSameForAnyThreads") {
  const ScratchDirectory in;
  write_full_mesh(in / "mesh.ply");
  tiles_of(in, "one", TileCompression::kMeshopt, 1);
  tiles_of(in, "three", TileCompression::kMeshopt, 3);
  CHECK((test::files_of(in / "one") == test::files_of(in / "three")));
}

}  // namespace orbweave
