// Levels of detail that are interrupted: what was simplified is taken over by the next run, and the
// files are those of a run without interruption.
#include "engine/pipeline/output/stored_nodes.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "engine/levels/simplified_mesh.h"
#include "engine/levels/tileset.h"
#include "io/error.h"
#include "io/meshes/mesh_stream.h"
#include "io/meshes/mesh_writer.h"
#include "io/store/chunk_store.h"
#include "io/system/owned_files.h"
#include "tests/support/jobs.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::results_in;
using test::ScratchDirectory;

constexpr const char* kStage = "tileset";
constexpr std::uint64_t kLeafTriangles = 300;

/// A quarter of its faces are patches.
void write_torus(const ScratchDirectory& scratch, double bump = 0.02) {
  TriangleMesh mesh = test::moved(test::torus_mesh(6000), [&](Vec3 p) {
    return (8.0 + bump * std::sin(9.0 * p.x) * std::cos(11.0 * p.y)) * p;
  });
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    mesh.hole.push_back(i % 1000 < 250 ? static_cast<std::int32_t>(i / 1000) + 1 : 0);
  write_mesh(scratch / "mesh.ply", mesh);
}

LevelOptions level_options(const ScratchDirectory& scratch, NodeStore* nodes) {
  LevelOptions options;
  options.leaf_triangles = kLeafTriangles;
  options.threads = 2;
  options.directory = scratch / "work";
  options.nodes = nodes;
  return options;
}

/// A run as a process of its own makes it: opens the store, and leaves it when it ends. Stops as
/// soon as `most_tiles` are written; nothing is returned then.
std::optional<TilesetFacts> make_tiles(const ScratchDirectory& scratch, std::uint64_t most_tiles) {
  ChunkStore store(scratch / "work");
  const RecordScope scope(store.record());
  StoredNodes nodes(store, kStage);
  TilesetOptions options;
  options.levels = level_options(scratch, &nodes);
  StopToken stop;
  std::atomic<std::uint64_t> written{0};
  TilesetEvents events;
  events.written = [&] {
    if (++written == most_tiles) stop.request();
  };
  try {
    const auto mesh = open_mesh_stream(scratch / "mesh.ply");
    return write_tileset(*mesh, scratch / "tiles", options, events, stop);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kInterrupted) throw;
    return std::nullopt;
  }
}

constexpr std::uint64_t kAll = ~std::uint64_t{0};

std::map<std::string, std::string> tiles_in(const ScratchDirectory& scratch) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(scratch / "tiles"))
    files[entry.path().filename().string()] = bytes_of(entry.path());
  return files;
}

std::uint64_t simplified_tiles(const TilesetFacts& facts) {
  return facts.tiles - facts.levels.front().tiles;
}

SimplifiedFacts simplify(const ScratchDirectory& scratch, double ratio, const std::string& name) {
  ChunkStore store(scratch / "work");
  const RecordScope scope(store.record());
  StoredNodes nodes(store, kStage);
  SimplifyOptions options;
  options.levels = level_options(scratch, &nodes);
  options.target = {SimplifyTarget::Kind::kRatio, ratio};
  options.written = [](const Box&) { return MeshWriterOptions{}; };
  const StopToken stop;
  return write_simplified(scratch / "mesh.ply", scratch / name, options, {}, stop);
}

TEST_CASE("TilesetThatIsStoppedAnywhereGoesOnFromWhatWasSimplified") {
  const ScratchDirectory undisturbed;
  write_torus(undisturbed);
  const std::optional<TilesetFacts> whole = make_tiles(undisturbed, kAll);
  REQUIRE(whole);
  REQUIRE(whole->reused == 0);
  const std::uint64_t inner = simplified_tiles(*whole);
  const std::uint64_t leaves = whole->tiles - inner;
  REQUIRE(inner >= 10);
  for (const std::uint64_t tiles :
       {leaves - 1, leaves + 2, leaves + inner / 2, whole->tiles - 2, whole->tiles}) {
    const ScratchDirectory scratch;
    write_torus(scratch);
    INFO(tiles << " of " << whole->tiles);
    CHECK(make_tiles(scratch, tiles).has_value() == (tiles == whole->tiles));
    const std::uint64_t stored = results_in(scratch / "work" / kStage);
    // Two threads: another node may be on its way when the first of them stops.
    CHECK(stored + leaves >= std::min(tiles, whole->tiles));
    CHECK(stored + leaves <= std::max(leaves, tiles + 1));
    const std::optional<TilesetFacts> resumed = make_tiles(scratch, kAll);
    REQUIRE(resumed);
    CHECK(resumed->reused == stored);
    CHECK((tiles_in(scratch) == tiles_in(undisturbed)));
    CHECK(results_in(scratch / "work" / kStage) == inner);
  }
}

TEST_CASE("TilesetThatIsStoppedAgainAndAgainComesToItsEnd") {
  const ScratchDirectory undisturbed;
  write_torus(undisturbed);
  const std::optional<TilesetFacts> whole = make_tiles(undisturbed, kAll);
  REQUIRE(whole);
  const ScratchDirectory scratch;
  write_torus(scratch);
  std::uint64_t before = 0;
  for (std::uint64_t tiles = whole->levels.front().tiles + 3; tiles < whole->tiles; tiles += 3) {
    CHECK_FALSE(make_tiles(scratch, tiles));
    const std::uint64_t stored = results_in(scratch / "work" / kStage);
    CHECK(stored >= before);
    before = stored;
  }
  const std::optional<TilesetFacts> last = make_tiles(scratch, kAll);
  REQUIRE(last);
  CHECK(last->reused == before);
  CHECK(before > simplified_tiles(*last) / 2);
  CHECK((tiles_in(scratch) == tiles_in(undisturbed)));
}

TEST_CASE("StoredNodesOfAnotherMeshAreNotTaken") {
  const ScratchDirectory scratch;
  write_torus(scratch);
  REQUIRE(make_tiles(scratch, kAll));
  write_torus(scratch, 0.03);
  const std::optional<TilesetFacts> other = make_tiles(scratch, kAll);
  REQUIRE(other);
  CHECK(other->reused == 0);
  const ScratchDirectory alone;
  write_torus(alone, 0.03);
  REQUIRE(make_tiles(alone, kAll));
  CHECK((tiles_in(scratch) == tiles_in(alone)));
}

TEST_CASE("StoredNodeThatIsDamagedIsNoticedAndMadeAgainAlone") {
  const ScratchDirectory scratch;
  write_torus(scratch);
  const std::optional<TilesetFacts> whole = make_tiles(scratch, kAll);
  REQUIRE(whole);
  const auto expected = tiles_in(scratch);
  const fs::path root = scratch / "work" / kStage / "000000.h5";
  test::damage(root);
  try {
    make_tiles(scratch, kAll);
    FAIL("the damage was not noticed");
  } catch (const CorruptResult& damage) {
    CHECK(damage.path() == root);
    ChunkStore(scratch / "work").discard(kStage, 0);
  }
  const std::optional<TilesetFacts> again = make_tiles(scratch, kAll);
  REQUIRE(again);
  CHECK(again->reused + 1 == simplified_tiles(*whole));
  CHECK((tiles_in(scratch) == expected));
}

TEST_CASE("SimplifiedMeshTakesOverNodesWhateverItsTarget") {
  const ScratchDirectory alone;
  write_torus(alone);
  CHECK(simplify(alone, 0.1, "small.ply").nodes_reused == 0);
  const std::uint64_t of_small = results_in(alone / "work" / kStage);
  const ScratchDirectory scratch;
  write_torus(scratch);
  simplify(scratch, 0.3, "first.ply");
  const std::uint64_t of_first = results_in(scratch / "work" / kStage);
  REQUIRE(of_first > 0);
  REQUIRE(of_first < of_small);
  CHECK(simplify(scratch, 0.1, "small.ply").nodes_reused == of_first);
  CHECK((bytes_of(scratch / "small.ply") == bytes_of(alone / "small.ply")));
  CHECK(simplify(scratch, 0.1, "again.ply").nodes_reused == of_small);
  CHECK((bytes_of(scratch / "again.ply") == bytes_of(alone / "small.ply")));
}

}  // namespace
}  // namespace orbweave
