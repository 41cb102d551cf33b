#include "engine/pipeline/output/tile_export.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "engine/pipeline/output/tile.h"
#include "io/error.h"
#include "io/hex_digits.h"
#include "io/meshes/tile_directory.h"
#include "io/system/atomic_file.h"
#include "io/system/path_roles.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTileStage = directory_of(Stage::kTiles);
constexpr const char* kPartDocument = "part";
/// A point of a tile: two triangles, its flags, and a share of what is being written.
constexpr std::size_t kTilePointBytes = 96;
constexpr std::size_t kTileBytes = std::size_t{24} << 20;

/// What the index says of a tile.
struct StoredTile {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;  ///< of the file
  Box bounds;
  std::vector<TriangleRun> runs;
};

void commit_tile(ChunkStore& store, ChunkId chunk, const StoredTile& tile) {
  const std::array<std::uint64_t, 4> counts = {tile.vertices, tile.triangles, tile.bytes,
                                               tile.checksum};
  const ArrayView arrays[] = {
      {"counts", ScalarType::kUint64, 1, counts.size(), counts.data()},
      {"bounds", ScalarType::kFloat64, 6, 1, &tile.bounds},
      {"runs", ScalarType::kUint64, 3, tile.runs.size(), tile.runs.data()},
  };
  store.commit(kTileStage, chunk, arrays);
}

StoredTile load_tile(const ChunkStore& store, ChunkId chunk) {
  const auto stored = store.open(kTileStage, chunk);
  const auto counts = stored->read_all<std::uint64_t>("counts");
  StoredTile tile{counts.at(0), counts.at(1), counts.at(2), counts.at(3), {}, {}};
  tile.bounds = stored->read_all<Box>("bounds").at(0);
  tile.runs = stored->read_all<TriangleRun>("runs");
  return tile;
}

nlohmann::json to_json(const Box& box) {
  return {{box.min.x, box.min.y, box.min.z}, {box.max.x, box.max.y, box.max.z}};
}

nlohmann::json to_json(const StoredTile& tile, const std::string& file, std::uint64_t first_vertex,
                       std::uint64_t own_vertices) {
  nlohmann::json runs = nlohmann::json::array();
  for (const TriangleRun& run : tile.runs) runs.push_back({run.row, run.first, run.rows});
  return {{"file", file},
          {"bounds", to_json(tile.bounds)},
          {"vertices", tile.vertices},
          {"triangles", tile.triangles},
          {"bytes", tile.bytes},
          {"xxh3", hex_digits(tile.checksum)},
          {"first_vertex", first_vertex},
          {"own_vertices", own_vertices},
          {"runs", std::move(runs)}};
}

class TileExport {
 public:
  TileExport(StageRunner& runner, const TileInput& input, fs::path directory)
      : runner_(runner),
        input_(input),
        directory_(std::move(directory)),
        runs_(patch_runs(runner.store, input)),
        rows_(first_rows(input)) {}

  void make(ChunkId chunk) const {
    const auto [begin, end] =
        std::equal_range(runs_.begin(), runs_.end(), PatchRun{chunk, 0, 0, 0},
                         [](const PatchRun& a, const PatchRun& b) { return a.chunk < b.chunk; });
    Tile tile(runner_.store, input_, chunk, {begin, end}, rows_);
    StoredTile facts{tile.vertices(), tile.triangles(), 0, 0, {}, tile.runs()};
    if (facts.triangles > 0) {
      const OutputOptions& output = runner_.job.output;
      const fs::path file = directory_ / tile_name(output.mesh, chunk);
      const auto writer = open_mesh_writer(file, tile.header(), input_.options);
      tile.write(*writer, facts.bounds);
      writer->finish();
      facts.bytes = writer->bytes_written();
      facts.checksum = file_checksum(file);
    }
    commit_tile(runner_.store, chunk, facts);
  }

  /// Returns the bytes of all files.
  std::uint64_t write_index(const SurfaceDigest& digest) const {
    std::uint64_t bytes = 0;
    nlohmann::json tiles = nlohmann::json::array();
    for (ChunkId chunk = 0; chunk < input_.partition.octree.chunks().size(); ++chunk) {
      const StoredTile tile = load_tile(runner_.store, chunk);
      if (tile.triangles == 0) continue;
      const std::uint64_t first = input_.used.before_chunk(chunk);
      const std::uint64_t last = input_.used.before_chunk(chunk + 1);
      tiles.push_back(
          to_json(tile, tile_name(runner_.job.output.mesh, chunk), first, last - first));
      bytes += tile.bytes;
    }
    nlohmann::json index = {{"format", kTileFormat},
                            {"version", 1},
                            {"vertices", input_.header.vertices},
                            {"triangles", input_.header.triangles},
                            {"bounds", to_json(digest.bounds())},
                            {"checksum", digest.checksum()},
                            {"tiles", std::move(tiles)}};
    const Vec3 origin = input_.options.origin;
    if (origin != Vec3{}) index["origin"] = {origin.x, origin.y, origin.z};
    AtomicFile file(directory_ / kTileIndex);
    file.write(index.dump(1) + "\n");
    file.commit();
    return bytes + file.bytes_written();
  }

 private:
  StageRunner& runner_;
  const TileInput& input_;
  fs::path directory_;
  std::vector<PatchRun> runs_;  // by chunk
  FirstRows rows_;
};

}  // namespace

void check_tile_format(const OutputOptions& output) {
  if (output.mesh == "-") {
    throw_usage("tiles are several files, standard output is one stream",
                {.file = {},
                 .place = "output.tiles",
                 .found = "output.mesh = \"-\"",
                 .expected = "the name of a .ply file",
                 .advice = {}});
  }
  const std::string extension = tile_directory_of(output.mesh).replace_extension(".ply").string();
  if (output.mesh != extension && output.mesh != extension + ".gz") {
    throw_usage("this format has no place for the numbers of a tile's vertices",
                {.file = output.mesh,
                 .place = "output.tiles",
                 .found = fs::path(output.mesh).extension().string(),
                 .expected = ".ply or .ply.gz",
                 .advice = {}});
  }
}

void check_tile_place(const OutputOptions& output) {
  check_tile_directory(tile_directory_of(output.mesh));
}

std::uint64_t export_tiles(StageRunner& runner, StageClock& clock, const TileInput& input,
                           SurfaceDigest& digest) {
  std::optional<TileDirectory> target;
  by_root(runner, [&] {
    runner.store.begin_stage_anew(kTileStage, "tiles of this run");
    target.emplace(final_target(tile_directory_of(runner.job.output.mesh)));
    runner.store.commit_document(kTileStage, kPartDocument, target->temporary().string());
  });
  const std::string part = runner.store.expected_document(kTileStage, kPartDocument);
  const TileExport tiles(runner, input, part);

  const MemoryPlan plan = runner.job.memory_plan(input.partition.points(), input.partition.schema);
  std::vector<ChunkWork> work;
  for (ChunkId chunk = 0; chunk < input.partition.octree.chunks().size(); ++chunk) {
    const std::uint64_t points = input.partition.points_in(chunk);
    work.push_back({chunk, kTileBytes + points * kTilePointBytes, points, points});
  }
  share_chunks(runner, clock, kTileStage, std::move(work), plan.chunks_in_flight_bytes,
               [&](ChunkId chunk) { tiles.make(chunk); });
  if (!runner.communicator.is_root()) return 0;
  digest = digest_pieces(runner, input.pieces);
  const std::uint64_t bytes = tiles.write_index(digest);
  target->commit();
  return bytes;
}

}  // namespace orbweave
