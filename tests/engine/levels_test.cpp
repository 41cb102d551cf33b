// Levels of detail: what a viewer of the tiles relies on.
#include "engine/levels/levels.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "engine/geometry/triangle_tree.h"
#include "engine/levels/flaps.h"
#include "engine/levels/soundness.h"
#include "engine/levels/tileset.h"
#include "engine/levels/tileset_work.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "tests/io/glb_file.h"
#include "tests/support/data.h"
#include "tests/support/folder_files.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using Catch::Contains;
using nlohmann::json;
using test::GlbFile;
using test::ScratchDirectory;

constexpr std::uint64_t kLeafTriangles = 800;
constexpr double kLattice = 1024.0;

/// Coordinates that floats hold about any middle of them.
Vec3 on_lattice(Vec3 p) {
  return {std::round(p.x * kLattice) / kLattice, std::round(p.y * kLattice) / kLattice,
          std::round(p.z * kLattice) / kLattice};
}

/// Closed, and bumpy enough for errors to matter.
TriangleMesh bumpy_torus(std::size_t vertices = 6000) {
  return test::moved(test::torus_mesh(vertices), [](Vec3 p) {
    const double bump = 1.0 + 0.02 * std::sin(9.0 * p.x) * std::cos(11.0 * p.y);
    return on_lattice(8.0 * bump * p);
  });
}

/// Open, with a hole.
TriangleMesh open_sheet() {
  TriangleMesh mesh = test::grid_mesh(60, 40, false, [](double u, double v) {
    return on_lattice({30.0 * u, 20.0 * v, std::sin(8.0 * u) * std::cos(6.0 * v)});
  });
  test::cut(mesh, [](Vec3 p) { return norm(p - Vec3{12.0, 9.0, p.z}) < 3.0; });
  return mesh;
}

/// Writes a mesh and its tileset; the tileset lies in `scratch / name`.
TilesetFacts make_tileset(const ScratchDirectory& scratch, const TriangleMesh& mesh,
                          const std::string& name = "tiles", TilesetOptions options = {}) {
  write_mesh(scratch / "mesh.ply", mesh);
  options.levels.leaf_triangles = kLeafTriangles;
  options.levels.directory = scratch / (name + ".work");
  const TilesetWork work(options.levels.directory);
  const StopToken stop;
  return write_tileset(*open_mesh_stream(scratch / "mesh.ply"), scratch / name, options, {}, stop);
}

/// A corner, exact.
using Place = std::array<double, 3>;
Place place_of(Vec3 p) { return {p.x, p.y, p.z}; }

/// A tile as its viewer finds it.
struct ReadTile {
  int level = 0;
  double error = 0.0;
  Box box;
  std::vector<std::array<Vec3, 3>> triangles;
  std::vector<ReadTile> children;
};

class TilesetReader {
 public:
  explicit TilesetReader(const fs::path& directory) : directory_(directory) {
    std::ifstream stream(directory / kTilesetName);
    document = json::parse(stream);
    const auto m = document["root"]["transform"].get<std::vector<double>>();
    origin_ = {m[12], m[13], m[14]};
    root = read(document["root"]);
  }
  json document;
  ReadTile root;

 private:
  ReadTile read(const json& tile) {
    ReadTile result;
    result.level = tile["extras"]["level"];
    result.error = tile["geometricError"];
    const auto b = tile["boundingVolume"]["box"].get<std::vector<double>>();
    const Vec3 middle{b[0], b[1], b[2]};
    const Vec3 half{b[3], b[7], b[11]};
    result.box = {middle - half, middle + half};
    const GlbFile glb(directory_ / tile["content"]["uri"].get<std::string>());
    std::vector<Vec3> places;
    for (const Vec3& seen : glb.seen_positions()) {
      const Vec3 upright{seen.x, -seen.z, seen.y};  // what every viewer of 3D Tiles does
      CHECK(result.box.contains(upright));
      places.push_back(upright + origin_);
    }
    for (const Triangle& t : glb.triangles())
      result.triangles.push_back({places[t[0]], places[t[1]], places[t[2]]});
    if (tile.contains("children"))
      for (const json& child : tile["children"]) result.children.push_back(read(child));
    return result;
  }

  fs::path directory_;
  Vec3 origin_;
};

template <class Visit>
void visit_tiles(const ReadTile& tile, const Visit& visit) {
  visit(tile);
  for (const ReadTile& child : tile.children) visit_tiles(child, visit);
}

/// The triangles that a viewer shows which refines every tile that `refines` is true for.
void shown(const ReadTile& tile, const std::function<bool(const ReadTile&)>& refines,
           std::vector<std::array<Vec3, 3>>& triangles) {
  if (tile.children.empty() || !refines(tile)) {
    triangles.insert(triangles.end(), tile.triangles.begin(), tile.triangles.end());
    return;
  }
  for (const ReadTile& child : tile.children) shown(child, refines, triangles);
}

/// Edges, by their ends, that not exactly two triangles have, in opposite directions.
std::vector<std::pair<Place, Place>> open_edges_of(
    const std::vector<std::array<Vec3, 3>>& triangles) {
  std::map<std::pair<Place, Place>, int> balance;
  for (const auto& t : triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const Place a = place_of(t[c]);
      const Place b = place_of(t[(c + 1) % 3]);
      if (a < b)
        ++balance[{a, b}];
      else
        --balance[{b, a}];
    }
  std::vector<std::pair<Place, Place>> open;
  for (const auto& [edge, count] : balance)
    if (count != 0) open.push_back(edge);
  return open;
}

std::size_t open_edge_count(const std::vector<std::array<Vec3, 3>>& triangles) {
  return open_edges_of(triangles).size();
}

TriangleMesh soup(const std::vector<std::array<Vec3, 3>>& triangles) {
  TriangleMesh mesh;
  for (const auto& t : triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.positions.size());
    mesh.vertices.positions.insert(mesh.vertices.positions.end(), t.begin(), t.end());
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

}  // namespace

TEST_CASE("LeavesHoldEveryTriangleExactlyOnce") {
  for (const TriangleMesh& mesh : {bumpy_torus(), open_sheet()}) {
    const ScratchDirectory scratch;
    make_tileset(scratch, mesh);
    const TilesetReader tiles(scratch / "tiles");
    std::multiset<std::array<Place, 3>> expected;
    std::multiset<std::array<Place, 3>> found;
    const auto turned = [](std::array<Place, 3> t) {
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
      return t;
    };
    for (const Triangle& t : mesh.triangles)
      expected.insert(
          turned({place_of(mesh.vertices.positions[t[0]]), place_of(mesh.vertices.positions[t[1]]),
                  place_of(mesh.vertices.positions[t[2]])}));
    visit_tiles(tiles.root, [&](const ReadTile& tile) {
      if (!tile.children.empty()) return;
      CHECK(tile.triangles.size() <= kLeafTriangles);
      for (const auto& t : tile.triangles)
        found.insert(turned({place_of(t[0]), place_of(t[1]), place_of(t[2])}));
    });
    CHECK(found == expected);
  }
}

TEST_CASE("BoxesNestAndErrorsFallFromParentToChild") {
  const ScratchDirectory scratch;
  make_tileset(scratch, bumpy_torus());
  const TilesetReader tiles(scratch / "tiles");
  CHECK(tiles.document["asset"]["version"] == "1.1");
  CHECK(tiles.document["geometricError"].get<double>() > tiles.root.error);
  std::size_t parents = 0;
  visit_tiles(tiles.root, [&](const ReadTile& tile) {
    if (tile.children.empty()) CHECK(tile.error == 0.0);
    for (const ReadTile& child : tile.children) {
      CHECK(child.error < tile.error);
      CHECK(child.level < tile.level);
      CHECK(tile.box.contains(child.box.min));
      CHECK(tile.box.contains(child.box.max));
    }
    parents += tile.children.empty() ? 0 : 1;
  });
  CHECK(parents > 3);
}

TEST_CASE("TilesOfAnyTwoLevelsMeetVertexByVertex") {
  const ScratchDirectory scratch;
  make_tileset(scratch, bumpy_torus());
  const TilesetReader tiles(scratch / "tiles");
  const auto is_closed = [&](const std::function<bool(const ReadTile&)>& refines) {
    std::vector<std::array<Vec3, 3>> triangles;
    shown(tiles.root, refines, triangles);
    CHECK(open_edge_count(triangles) == 0);
    return triangles.size();
  };
  std::size_t last = 0;
  for (int level = tiles.root.level + 1; level >= 0; --level) {
    const std::size_t size = is_closed([&](const ReadTile& tile) { return tile.level > level; });
    CHECK(size >= last);
    last = size;
  }
  // Seen from one end: fine tiles there, coarse ones far away.
  for (const double reach : {-6.0, -2.0, 0.0, 3.0})
    is_closed([&](const ReadTile& tile) { return tile.box.min.x < reach; });
}

TEST_CASE("OnlyRimsOfTheMeshAreOpenAtAnyLevelAndTheyBecomeSimpler") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = open_sheet();
  make_tileset(scratch, mesh);
  const TilesetReader tiles(scratch / "tiles");
  std::vector<std::array<Vec3, 3>> whole;
  for (const Triangle& t : mesh.triangles)
    whole.push_back({mesh.vertices.positions[t[0]], mesh.vertices.positions[t[1]],
                     mesh.vertices.positions[t[2]]});
  std::set<Place> rim;
  for (const auto& [a, b] : open_edges_of(whole)) {
    rim.insert(a);
    rim.insert(b);
  }
  std::size_t last = open_edge_count(whole);
  for (const int level : {0, 1, 9}) {
    std::vector<std::array<Vec3, 3>> triangles;
    shown(
        tiles.root, [&](const ReadTile& tile) { return tile.level > level; }, triangles);
    const auto open = open_edges_of(triangles);
    for (const auto& [a, b] : open) CHECK((rim.count(a) == 1 && rim.count(b) == 1));
    CHECK(open.size() <= last);
    last = open.size();
  }
  CHECK(last < open_edge_count(whole));
}

TEST_CASE("NoTileIsFartherFromTheMeshThanItsErrorSays") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = bumpy_torus();
  make_tileset(scratch, mesh);
  const TilesetReader tiles(scratch / "tiles");
  const TriangleTree tree(mesh);
  visit_tiles(tiles.root, [&](const ReadTile& tile) {
    double farthest = 0.0;
    for (const auto& t : tile.triangles)
      for (const double weight : {0.1, 1.0 / 3.0, 0.6}) {
        const double rest = 0.5 * (1.0 - weight);
        const Vec3 p = weight * t[0] + rest * t[1] + rest * t[2];
        farthest = std::max(farthest, std::sqrt(tree.squared_distance(p)));
      }
    CHECK(farthest <= tile.error + 1e-9);
  });
  for (const int level : {1, 2, tiles.root.level}) {
    std::vector<std::array<Vec3, 3>> triangles;
    shown(
        tiles.root, [&](const ReadTile& tile) { return tile.level > level; }, triangles);
    const TriangleMesh coarse = soup(triangles);
    const TriangleTree coarse_tree(coarse);
    double stated = 0.0;
    visit_tiles(tiles.root, [&](const ReadTile& tile) {
      if (tile.level <= level) stated = std::max(stated, tile.error);
    });
    double farthest = 0.0;
    for (const Vec3& p : mesh.vertices.positions)
      farthest = std::max(farthest, std::sqrt(coarse_tree.squared_distance(p)));
    CHECK(farthest <= stated + 1e-9);
  }
}

TEST_CASE("NoLevelIsMeasuredFartherFromTheMeshThanItStates") {
  for (const TriangleMesh& mesh : {bumpy_torus(), open_sheet()}) {
    const ScratchDirectory scratch;
    TilesetOptions options;
    options.measures = true;
    const TilesetFacts facts = make_tileset(scratch, mesh, "one", options);
    REQUIRE(facts.levels.size() > 2);
    CHECK(facts.levels[0].measured->distance == 0.0);
    for (std::size_t i = 1; i < facts.levels.size(); ++i) {
      REQUIRE(facts.levels[i].measured);
      const LevelDistance& measured = *facts.levels[i].measured;
      CHECK(measured.distance <= facts.levels[i].error);
      CHECK(measured.distance > facts.levels[i].error / 50.0);
      CHECK(measured.mean_distance > 0.0);
      CHECK(measured.mean_distance < measured.distance);
      CHECK(measured.samples > mesh.vertices.size());
      CHECK_FALSE(measured.has_colors);
    }
    options.levels.threads = 3;
    const TilesetFacts again = make_tileset(scratch, mesh, "two", options);
    for (std::size_t i = 0; i < facts.levels.size(); ++i)
      CHECK(again.levels[i].measured->distance == facts.levels[i].measured->distance);
    CHECK(test::files_of(scratch / "one") == test::files_of(scratch / "two"));
  }
}

TEST_CASE("ColorsOfALevelAreMeasuredAgainstThoseOfTheMesh") {
  const auto color_errors = [](const std::function<std::uint8_t(Vec3)>& red) {
    TriangleMesh mesh = bumpy_torus();
    mesh.vertices.schema.attributes = {
        {"red", ScalarType::kUint8}, {"green", ScalarType::kUint8}, {"blue", ScalarType::kUint8}};
    for (const Vec3& p : mesh.vertices.positions)
      for (const std::uint8_t value : {red(p), std::uint8_t{9}, std::uint8_t{9}})
        mesh.vertices.attributes.push_back(static_cast<std::byte>(value));
    const ScratchDirectory scratch;
    TilesetOptions options;
    options.measures = true;
    std::vector<double> errors;
    for (const TilesetLevel& level : make_tileset(scratch, mesh, "tiles", options).levels) {
      CHECK(level.measured->has_colors);
      errors.push_back(level.measured->color_error);
    }
    return errors;
  };
  for (const double error : color_errors([](Vec3) { return std::uint8_t{200}; }))
    CHECK(error < 1e-9);
  const std::vector<double> smooth = color_errors(
      [](Vec3 p) { return static_cast<std::uint8_t>(std::lround(127.0 + 8.0 * p.x)); });
  const std::vector<double> checkered = color_errors([](Vec3 p) {
    return static_cast<std::uint8_t>(std::sin(20.0 * p.x) * std::sin(20.0 * p.y) > 0 ? 255 : 0);
  });
  for (std::size_t i = 1; i < smooth.size(); ++i) {
    CHECK(smooth[i] < 0.02);
    CHECK(checkered[i] > 5.0 * smooth[i]);
    CHECK(checkered[i] < 1.0);
  }
  CHECK(smooth[0] < 1e-9);
}

TEST_CASE("TilesetIsTheSameForAnyThreadsAndMemory") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = bumpy_torus();
  TilesetOptions options;
  make_tileset(scratch, mesh, "a", options);
  options.levels.threads = 3;
  make_tileset(scratch, mesh, "b", options);
  options.levels.memory_bytes = std::uint64_t{64} << 20;
  make_tileset(scratch, mesh, "c", options);
  CHECK(test::files_of(scratch / "a") == test::files_of(scratch / "b"));
  CHECK(test::files_of(scratch / "a") == test::files_of(scratch / "c"));
}

TEST_CASE("ColorsAndNormalsComeWithTheirVertices") {
  const ScratchDirectory scratch;
  TriangleMesh mesh = bumpy_torus();
  mesh.vertices.schema.has_normals = true;
  mesh.vertices.schema.attributes = {{"time", ScalarType::kFloat64},
                                     {"blue", ScalarType::kUint8},
                                     {"red", ScalarType::kUint8},
                                     {"green", ScalarType::kUint8}};
  for (const Vec3& p : mesh.vertices.positions) {
    mesh.vertices.normals.push_back(normalized(p));
    for (int i = 0; i < 8; ++i) mesh.vertices.attributes.push_back(std::byte{7});
    // Blue, red, green by the signs of the coordinates.
    for (const double c : {p.z, p.x, p.y})
      mesh.vertices.attributes.push_back(c > 0 ? std::byte{255} : std::byte{0});
  }
  make_tileset(scratch, mesh);
  for (const auto& entry : fs::directory_iterator(scratch / "tiles")) {
    if (entry.path().extension() != ".glb") continue;
    const GlbFile glb(entry.path());
    const std::vector<Vec3> seen = glb.seen_positions();
    const Vec3 middle = Box{mesh.vertices.bounds()}.center();
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const Vec3 p = Vec3{seen[i].x, -seen[i].z, seen[i].y} + middle;
      const auto color = glb.element<std::uint16_t, 4>(glb.accessor("COLOR_0"), i);
      CHECK(color[0] == (p.x > 0 ? 65535 : 0));
      CHECK(color[1] == (p.y > 0 ? 65535 : 0));
      CHECK(color[2] == (p.z > 0 ? 65535 : 0));
      const auto n = glb.element<float, 3>(glb.accessor("NORMAL"), i);
      CHECK(norm(Vec3{n[0], n[1], n[2]} - normalized(p)) < 1e-5);
    }
  }
}

TEST_CASE("ATilesetReplacesAnEarlierOneAndNothingElse") {
  const ScratchDirectory scratch;
  make_tileset(scratch, bumpy_torus());
  const auto before = test::files_of(scratch / "tiles");
  make_tileset(scratch, open_sheet());
  CHECK(test::files_of(scratch / "tiles") != before);
  CHECK_FALSE(fs::exists(scratch / "tiles.work"));
  std::ofstream(scratch / "tiles" / "notes.txt") << "mine";
  CHECK_THROWS_WITH(make_tileset(scratch, bumpy_torus()), Contains("notes.txt"));
  CHECK(test::read_file(scratch / "tiles" / "notes.txt") == "mine");
}

TEST_CASE("AnInterruptedTilesetLeavesNothing") {
  const ScratchDirectory scratch;
  write_mesh(scratch / "mesh.ply", bumpy_torus());
  {
    const TilesetWork work(scratch / "work");
    TilesetOptions options;
    options.levels.directory = scratch / "work";
    options.levels.leaf_triangles = kLeafTriangles;
    StopToken stop;
    TilesetEvents events;
    std::once_flag first;
    events.written = [&] { std::call_once(first, [&] { stop.request(); }); };
    try {
      write_tileset(*open_mesh_stream(scratch / "mesh.ply"), scratch / "tiles", options, events,
                    stop);
      FAIL("went on");
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kInterrupted);
    }
  }
  CHECK(test::files_of(scratch.path()).size() == 1);
}

TEST_CASE("MeshesThatCannotBecomeTilesAreRefused") {
  const ScratchDirectory scratch;
  TriangleMesh mesh = bumpy_torus();
  mesh.vertices.positions[17].y = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(make_tileset(scratch, mesh), Contains("not finite") && Contains("fill"));
  TilesetOptions small;
  small.levels.memory_bytes = std::uint64_t{48} << 20;
  CHECK_THROWS_WITH(make_tileset(scratch, bumpy_torus(), "small", small),
                    Contains("memory budget") && Contains("--leaf-triangles"));
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 0, 0}};
  write_cloud(scratch / "cloud.ply", cloud);
  CHECK_THROWS_WITH(open_mesh_stream(scratch / "cloud.ply"), Contains("no faces"));
}

TEST_CASE("FlapsGoAndTheRestOfTheSurfaceStays") {
  // Two triangles of a sheet, and a flap at the edge between them.
  const std::vector<Triangle> sheet = {{0, 1, 2}, {2, 1, 3}};
  std::vector<Triangle> triangles = {sheet[0], {4, 1, 2}, sheet[1], {1, 4, 2}};
  const std::vector<std::uint32_t> unsound = unsound_vertices(triangles);
  CHECK(unsound == std::vector<std::uint32_t>{1, 2});
  CHECK(without_flaps(triangles, unsound, {}) == sheet);
  CHECK(without_flaps(triangles, unsound, std::vector<std::uint32_t>{2}) == sheet);
  CHECK(without_flaps(triangles, unsound, std::vector<std::uint32_t>{2, 4}) == triangles);
  // The same triangle twice in the same direction is no flap.
  triangles[3] = {4, 1, 2};
  CHECK(without_flaps(triangles, unsound_vertices(triangles), {}) == triangles);
}

TEST_CASE("TrianglesSortedInManyRunsAreThoseOfOneRun") {
  const ScratchDirectory scratch;
  const StopToken stop;
  std::vector<CodedTriangle> triangles;
  for (std::uint64_t i = 0; i < 60'000; ++i)
    triangles.push_back({(i * 0x9E3779B97F4A7C15ULL) >> 40, {i, i % 7, i % 11}});
  const auto sorted = [&](std::size_t run_bytes) {
    TriangleSorter sorter(scratch.path(), run_bytes);
    for (const CodedTriangle& t : triangles) sorter.add(t);
    return sorter.finish(stop);
  };
  const SortedTriangles many = sorted(1);
  const SortedTriangles one = sorted(std::size_t{64} << 20);
  REQUIRE(many.size() == triangles.size());
  CHECK(many.read(0, many.size()) == one.read(0, one.size()));
  std::sort(triangles.begin(), triangles.end());
  CHECK(many.read(0, many.size()) == triangles);
  const std::uint64_t code = triangles[30'000].code;
  const std::uint64_t at = many.first_at_least(code, 0, many.size());
  CHECK(triangles[at].code == code);
  CHECK(triangles[at - 1].code < code);
  CHECK(many.first_at_least(~std::uint64_t{0}, 0, many.size()) == many.size());
}

TEST_CASE("MeshStreamsReadWhatReadMeshReads") {
  const ScratchDirectory scratch;
  const TriangleMesh mesh = open_sheet();
  const std::string quads =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 "
      "0\n0 1 0\n4 0 1 2 3\n";
  std::ofstream(scratch / "quads.ply") << quads;
  MeshWriterOptions options;
  for (const char* name : {"a.ply", "a.ply.gz", "a.obj", "a.stl"}) {
    write_mesh(scratch / name, mesh, options);
  }
  for (const char* name : {"a.ply", "a.ply.gz", "a.obj", "a.stl", "quads.ply"}) {
    INFO(name);
    const TriangleMesh expected = read_mesh(scratch / name);
    const auto stream = open_mesh_stream(scratch / name);
    CHECK(stream->vertices() == expected.vertices.size());
    PointCloud vertices;
    vertices.schema = stream->schema();
    for (PointCloud batch; stream->read_vertices(batch, 1000);) vertices.append(batch);
    CHECK(vertices.positions == expected.vertices.positions);
    std::vector<Triangle> triangles;
    for (std::vector<Triangle64> batch; stream->read_triangles(batch, 1000);)
      for (const Triangle64& t : batch)
        triangles.push_back({static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]),
                             static_cast<std::uint32_t>(t[2])});
    CHECK(triangles == expected.triangles);
  }
  std::string wrong = quads;
  wrong.replace(wrong.rfind("2 3"), 3, "2 4");
  std::ofstream(scratch / "quads.ply") << wrong;
  const auto stream = open_mesh_stream(scratch / "quads.ply");
  PointCloud vertices;
  while (stream->read_vertices(vertices, 1000)) {
  }
  std::vector<Triangle64> triangles;
  CHECK_THROWS_WITH(stream->read_triangles(triangles, 10),
                    Contains("quads.ply") && Contains("vertex 4"));
}

}  // namespace orbweave
