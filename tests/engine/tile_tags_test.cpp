// What tiles say of faces: patches of holes, their confidence, components.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "engine/levels/face_tags.h"
#include "engine/levels/listed_holes.h"
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

constexpr float kConfidence = 0.25F;
constexpr int kFirstHole = 1, kSecondHole = 2;

/// Two caps of each sphere are patches.
int hole_at(Vec3 p) {
  if (p.z > 0.9) return kFirstHole;
  return p.x > 0.95 ? kSecondHole : 0;
}

Vec3 middle_of(const TriangleMesh& mesh, const Triangle& t) {
  const std::vector<Vec3>& at = mesh.vertices.positions;
  return (1.0 / 3.0) * (at[t[0]] + at[t[1]] + at[t[2]]);
}

/// A sphere with two patches, their triangles at the end, and a smaller sphere aside.
TriangleMesh patched_spheres() {
  const TriangleMesh small = test::moved(test::sphere_mesh(3), [](Vec3 p) {
    return 0.125 * p + Vec3{2.0, 0.0, 0.0};
  });
  TriangleMesh mesh = test::joined(test::sphere_mesh(4), small);
  const auto hole_of = [&](const Triangle& t) {
    const Vec3 middle = middle_of(mesh, t);
    return middle.x > 1.5 ? 0 : hole_at(middle);
  };
  std::ranges::stable_sort(mesh.triangles, {}, hole_of);
  for (const Triangle& t : mesh.triangles) mesh.hole.push_back(hole_of(t));
  return mesh;
}

void write_patched(const fs::path& file, const TriangleMesh& mesh) {
  MeshWriterOptions options;
  options.has_confidence = true;
  options.confidence = {kConfidence, 2.0F * kConfidence};
  write_mesh(file, mesh, options);
}

TilesetFacts tiles_of(const fs::path& mesh, const fs::path& folder, std::uint64_t leaf_triangles,
                      int threads = 1) {
  TilesetOptions options;
  options.levels.leaf_triangles = leaf_triangles;
  options.levels.directory = folder.string() + ".work";
  options.levels.threads = threads;
  const TilesetWork work(options.levels.directory);
  const StopToken stop;
  return write_tileset(*open_mesh_stream(mesh), folder, options, {}, stop);
}

json document_of(const fs::path& folder) {
  std::ifstream stream(folder / kTilesetName);
  return json::parse(stream);
}

std::vector<float> values_of(const GlbFile& glb, const std::string& attribute, float otherwise) {
  std::vector<float> values(glb.accessor("POSITION").at("count").get<std::size_t>(), otherwise);
  if (!glb.has(attribute)) return values;
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = glb.element<float, 1>(glb.accessor(attribute), i)[0];
  return values;
}

/// A face as a viewer finds it.
struct SeenFace {
  Vec3 middle;
  float hole = 0.0F, confidence = 1.0F, component = 0.0F;
};

/// Faces of the tiles of a level; -1: of all levels.
std::vector<SeenFace> faces_of(const fs::path& folder, int level) {
  const json document = document_of(folder);
  const auto m = document["root"]["transform"].get<std::vector<double>>();
  std::vector<SeenFace> faces;
  std::vector<json> left = {document["root"]};
  while (!left.empty()) {
    const json tile = left.back();
    left.pop_back();
    if (tile.contains("children"))
      for (const json& child : tile["children"]) left.push_back(child);
    if (level >= 0 && tile["extras"]["level"] != level) continue;
    const GlbFile glb(folder / tile["content"]["uri"].get<std::string>());
    const std::vector<Vec3> seen = glb.seen_positions();
    const std::vector<float> hole = values_of(glb, "_HOLE", 0.0F);
    const std::vector<float> confidence = values_of(glb, "_CONFIDENCE", 1.0F);
    const std::vector<float> component = values_of(glb, "_COMPONENT", 0.0F);
    for (const Triangle& t : glb.triangles()) {
      const Vec3 y_up = (1.0 / 3.0) * (seen[t[0]] + seen[t[1]] + seen[t[2]]);
      const Vec3 middle = Vec3{y_up.x, -y_up.z, y_up.y} + Vec3{m[12], m[13], m[14]};
      faces.push_back({middle, hole[t[0]], confidence[t[0]], component[t[0]]});
      for (const std::uint32_t corner : t) {
        CHECK(hole[corner] == hole[t[0]]);
        CHECK(confidence[corner] == confidence[t[0]]);
        CHECK(component[corner] == component[t[0]]);
      }
    }
  }
  return faces;
}

}  // namespace

TEST_CASE("EveryFaceOfTheFinestTilesHasItsHoleItsConfidenceAndItsComponent") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = patched_spheres();
  write_patched(scratch / "mesh.ply", mesh);
  tiles_of(scratch / "mesh.ply", scratch / "tiles", 300);
  const std::vector<SeenFace> faces = faces_of(scratch / "tiles", 0);
  REQUIRE(faces.size() == mesh.triangles.size());
  std::map<float, std::size_t> counts;
  for (const SeenFace& face : faces) {
    const bool is_aside = face.middle.x > 1.5;
    const int hole = is_aside ? 0 : hole_at(face.middle);
    CHECK(face.hole == static_cast<float>(hole));
    CHECK(face.confidence == (hole == 0 ? 1.0F : static_cast<float>(hole) * kConfidence));
    CHECK(face.component == (is_aside ? 1.0F : 0.0F));
    ++counts[face.hole];
  }
  CHECK(counts.size() == 3);
}

TEST_CASE("FacesOfCoarserTilesKeepTheirComponentsAndThePatchesTheyLieIn") {
  const ScratchDirectory scratch;
  write_patched(scratch / "mesh.ply", patched_spheres());
  const TilesetFacts facts = tiles_of(scratch / "mesh.ply", scratch / "tiles", 300);
  REQUIRE(facts.levels.size() > 2);
  const double error = facts.levels.back().error;
  std::set<float> holes;
  for (const SeenFace& face : faces_of(scratch / "tiles", -1)) {
    CHECK(face.component == (face.middle.x > 1.5 ? 1.0F : 0.0F));
    CHECK(face.confidence == (face.hole == 0.0F ? 1.0F : face.hole * kConfidence));
    // A face that has lost its rim may reach over it by as much as a coarse face is long.
    const double reach = std::sqrt(8.0 * error);
    if (face.hole == 1.0F) CHECK(face.middle.z > 0.9 - reach);
    if (face.hole == 2.0F) CHECK(face.middle.x > 0.95 - reach);
    if (face.middle.x < 1.5 && norm(face.middle - Vec3{0.0, 0.0, 1.0}) < 0.1)
      CHECK(face.hole == 1.0F);
    holes.insert(face.hole);
  }
  CHECK(holes == std::set<float>{0.0F, 1.0F, 2.0F});
  const std::vector<SeenFace> coarsest =
      faces_of(scratch / "tiles", static_cast<int>(facts.levels.size()) - 1);
  CHECK(std::ranges::any_of(coarsest, [](const SeenFace& face) { return face.hole == 1.0F; }));
}

TEST_CASE("TilesetListsItsHolesTheLargestFirstAndItsComponents") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = patched_spheres();
  write_patched(scratch / "mesh.ply", mesh);
  tiles_of(scratch / "mesh.ply", scratch / "tiles", 300);
  const json document = document_of(scratch / "tiles");
  const auto m = document["root"]["transform"].get<std::vector<double>>();
  const json& holes = document["extras"]["holes"];
  REQUIRE(holes.size() == 2);
  for (std::size_t i = 0; i < holes.size(); ++i) {
    const int hole = static_cast<int>(i) + 1;
    CHECK(holes[i]["hole"] == hole);
    CHECK(holes[i]["triangles"] == std::ranges::count(mesh.hole, hole));
    CHECK(holes[i]["confidence"] == static_cast<float>(hole) * kConfidence);
    const auto middle = holes[i]["middle"].get<std::vector<double>>();
    const Vec3 at = Vec3{middle[0], middle[1], middle[2]} + Vec3{m[12], m[13], m[14]};
    const Vec3 direction = hole == kFirstHole ? Vec3{0.0, 0.0, 1.0} : Vec3{1.0, 0.0, 0.0};
    CHECK(norm(at - direction) < 0.1);
  }
  CHECK(document["extras"]["components"] == 2);
  CHECK(document["extras"]["component_triangles"] == json({2048, 512}));
}

TEST_CASE("TaggedTilesAreTheSameForAnyThreads") {
  const ScratchDirectory scratch;
  write_patched(scratch / "mesh.ply", patched_spheres());
  tiles_of(scratch / "mesh.ply", scratch / "a", 300, 1);
  tiles_of(scratch / "mesh.ply", scratch / "b", 300, 3);
  CHECK(test::files_of(scratch / "a") == test::files_of(scratch / "b"));
}

TEST_CASE("TilesOfAMeshOfOnePieceWithoutPatchesSayNothingOfFaces") {
  const ScratchDirectory scratch;
  TriangleMesh mesh = test::sphere_mesh(4);
  mesh.hole.assign(mesh.triangles.size(), 0);
  write_patched(scratch / "mesh.ply", mesh);
  tiles_of(scratch / "mesh.ply", scratch / "tiles", 300);
  CHECK_FALSE(document_of(scratch / "tiles").contains("extras"));
  for (const auto& entry : fs::directory_iterator(scratch / "tiles")) {
    if (entry.path().extension() != ".glb") continue;
    const GlbFile glb(entry.path());
    CHECK(glb.primitive().at("attributes").size() == 1);
  }
}

namespace {

/// What a vertex tells, by its place; some vertices have no noise.
float confidence_at(Vec3 p) { return p.z > 0.1003 ? 0.75F : 0.25F; }
float noise_at(Vec3 p) { return p.x > 0.1003 ? 0.5F : -1.0F; }

template <class T>
void append_value(std::vector<std::byte>& bytes, T value) {
  const auto* at = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), at, at + sizeof value);
}

/// A sphere whose vertices have a confidence as scans have it, and what the program adds.
TriangleMesh telling_sphere() {
  TriangleMesh mesh = test::sphere_mesh(4);
  PointCloud& vertices = mesh.vertices;
  vertices.schema.attributes = {{"time", ScalarType::kUint16},
                                {"confidence", ScalarType::kFloat64},
                                {"quality_noise", ScalarType::kFloat32},
                                {"undersampled", ScalarType::kUint8}};
  for (const Vec3& p : vertices.positions) {
    append_value(vertices.attributes, std::uint16_t{7});
    append_value(vertices.attributes, static_cast<double>(confidence_at(p)));
    append_value(vertices.attributes, noise_at(p));
    append_value(vertices.attributes, std::uint8_t{255});
  }
  return mesh;
}

}  // namespace

TEST_CASE("VerticesOfTilesTellWhatTheVerticesOfTheMeshTell") {
  const ScratchDirectory scratch;
  write_mesh(scratch / "mesh.ply", telling_sphere());
  const TilesetFacts facts = tiles_of(scratch / "mesh.ply", scratch / "tiles", 300);
  REQUIRE(facts.levels.size() > 1);
  const json document = document_of(scratch / "tiles");
  const auto m = document["root"]["transform"].get<std::vector<double>>();
  std::size_t tiles = 0;
  for (const auto& entry : fs::directory_iterator(scratch / "tiles")) {
    if (entry.path().extension() != ".glb") continue;
    ++tiles;
    const GlbFile glb(entry.path());
    const std::vector<Vec3> seen = glb.seen_positions();
    const std::vector<float> confidence = values_of(glb, "_VERTEX_CONFIDENCE", -2.0F);
    const std::vector<float> noise = values_of(glb, "_QUALITY_NOISE", -2.0F);
    const std::vector<float> undersampled = values_of(glb, "_UNDERSAMPLED", -2.0F);
    for (std::size_t v = 0; v < seen.size(); ++v) {
      const Vec3 at = Vec3{seen[v].x, -seen[v].z, seen[v].y} + Vec3{m[12], m[13], m[14]};
      CHECK(confidence[v] == confidence_at(at));
      CHECK(noise[v] == noise_at(at));
      CHECK(undersampled[v] == -1.0F);
    }
  }
  CHECK(tiles == facts.tiles);
  // Of what no vertex tells there is no range.
  CHECK(document["extras"]["vertex_values"] ==
        json({{{"name", "vertex_confidence"}, {"low", 0.25}, {"high", 0.75}},
              {{"name", "quality_noise"}, {"low", 0.0}, {"high", 0.5}}}));
}

TEST_CASE("StreamsTellPatchesOfEveryTriangleOfAPolygon") {
  const ScratchDirectory scratch;
  std::ofstream(scratch / "quads.ply")
      << "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty "
         "float z\nelement face 2\nproperty list uchar int vertex_indices\nproperty double "
         "confidence\nproperty uchar hole\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n4 0 1 2 "
         "3 0.5 7\n3 1 4 2 2 0\n";
  const auto stream = open_mesh_stream(scratch / "quads.ply");
  CHECK((stream->has_holes() && stream->has_confidence()));
  for (PointCloud batch; stream->read_vertices(batch, 10);) {
  }
  std::vector<Triangle64> triangles;
  std::vector<FacePatch> patches;
  while (stream->read_triangles(triangles, 10))
    patches.insert(patches.end(), stream->patches().begin(), stream->patches().end());
  // A confidence beyond 1 is none.
  CHECK(patches == std::vector<FacePatch>{{7, 0.5F}, {7, 0.5F}, {0, 1.0F}});
}

TEST_CASE("AListedHoleIsOneWhereverItsTrianglesCome") {
  // Those of a simplified mesh lie between others, as its pieces have them.
  ListedHoles holes;
  for (const int x : {0, 1, 2})
    for (const std::int32_t hole : {3, 0, 8}) {
      const Vec3 from{1.0 * x, 1.0 * hole, 0.0};
      holes.add({hole, 0.5F}, {from, from + Vec3{1.0, 0.0, 0.0}, from + Vec3{0.0, 1.0, 0.0}});
    }
  CHECK(holes.count() == 2);
  const std::vector<ListedHole> listed = holes.largest();
  REQUIRE(listed.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(listed[i].hole == (i == 0 ? 3 : 8));
    CHECK(listed[i].triangles == 3);
    CHECK(listed[i].bounds.extent() == Vec3{3.0, 1.0, 0.0});
    CHECK(listed[i].area == Vec3{0.0, 0.0, 1.5});
  }
}

TEST_CASE("ListedHolesAreTheLargestHoweverManyThereAre") {
  ListedHoles holes;
  constexpr int kHoles = 5000;
  for (int hole = 1; hole <= kHoles; ++hole) {
    const double size = hole * 7 % kHoles + 1;
    holes.add({hole, 1.0F}, {Vec3{}, Vec3{size, 0.0, 0.0}, Vec3{0.0, size, 0.0}});
  }
  const std::vector<ListedHole> largest = holes.largest();
  CHECK(holes.count() == kHoles);
  REQUIRE(largest.size() == 300);
  for (std::size_t i = 0; i < largest.size(); ++i)
    CHECK(largest[i].bounds.extent().x == kHoles - static_cast<double>(i));
}

}  // namespace orbweave
