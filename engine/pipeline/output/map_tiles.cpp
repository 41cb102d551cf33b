#include "engine/pipeline/output/map_tiles.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/pipeline/output/map_cells.h"
#include "engine/pipeline/output/number_set.h"
#include "engine/pipeline/output/tile_columns.h"
#include "io/error.h"
#include "io/hex_digits.h"
#include "io/job/setting.h"
#include "io/meshes/tile_directory.h"
#include "io/system/atomic_file.h"
#include "io/system/disk_space.h"
#include "io/system/path_roles.h"
#include "io/text/quantity.h"
#include "partition/allowed_threads.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBatchRows = std::size_t{1} << 14;
/// Batches of triangles and vertices, and what the writer holds.
constexpr std::size_t kTileBytes = std::size_t{12} << 20;

/// What the index says of a tile.
struct WrittenTile {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;  ///< of the file
  Box bounds;
};

nlohmann::json to_json(const Box& box) {
  return {{box.min.x, box.min.y, box.min.z}, {box.max.x, box.max.y, box.max.z}};
}

class MapTiles {
 public:
  MapTiles(StageRunner& runner, const TileInput& input, const MapGrid& grid, const CutMesh& cut,
           fs::path directory)
      : runner_(runner), input_(input), grid_(grid), cut_(cut), directory_(std::move(directory)) {
    for (const auto& [cell, parts] : cut.triangles.cells()) cells_.push_back({cell, &parts, {}});
  }

  /// A few tiles at a time, as the budget has room for them.
  void write() {
    const ResolvedJob& job = runner_.job;
    const MemoryPlan plan = job.memory_plan(input_.partition.points(), input_.partition.schema);
    // A bit for each vertex, and as much again for the blocks' places.
    const std::uint64_t of_tile = kTileBytes + input_.header.vertices / 4;
    const std::uint64_t at_once =
        std::clamp<std::uint64_t>(plan.chunks_in_flight_bytes / of_tile, 1,
                                  static_cast<std::uint64_t>(std::max(1, runner_.threads())));
    tbb::task_arena arena(allowed_threads(static_cast<int>(at_once)));
    arena.execute([&] {
      tbb::parallel_for(std::size_t{0}, cells_.size(),
                        [&](std::size_t i) { write_tile(cells_[i]); });
    });
  }

  /// Returns the bytes of all files. The tiles go into the file one by one: there may be many.
  std::uint64_t write_index(const SurfaceDigest& digest) const {
    nlohmann::json head = {{"format", kTileFormat},
                           {"version", 1},
                           {"tile_size", grid_.size()},
                           {"vertices", input_.header.vertices},
                           {"triangles", input_.header.triangles},
                           {"bounds", to_json(digest.bounds())},
                           {"checksum", digest.checksum()}};
    const Vec3 origin = input_.options.origin;
    if (origin != Vec3{}) head["origin"] = {origin.x, origin.y, origin.z};
    std::string text = head.dump(1);
    text.erase(text.rfind('\n'));  // the closing brace comes last
    AtomicFile file(directory_ / kTileIndex);
    file.write(text + ",\n \"tiles\": [");
    std::uint64_t bytes = 0;
    const char* between = "\n  ";
    for (const Cell& cell : cells_) {
      file.write(between + entry_of(cell).dump());
      bytes += cell.tile.bytes;
      between = ",\n  ";
    }
    file.write("\n ]\n}\n");
    file.commit();
    return bytes + file.bytes_written();
  }

 private:
  struct Cell {
    MapCell cell;
    const std::vector<TrianglesByCell::Part>* parts = nullptr;
    WrittenTile tile;
  };

  std::string file_of(const Cell& cell) const {
    return map_tile_name(runner_.job.output.mesh, grid_.name(cell.cell));
  }

  nlohmann::json entry_of(const Cell& cell) const {
    const WrittenTile& tile = cell.tile;
    return {{"file", file_of(cell)},
            {"corner", {grid_.edge(cell.cell.x), grid_.edge(cell.cell.y)}},
            {"bounds", to_json(tile.bounds)},
            {"vertices", tile.vertices},
            {"triangles", tile.triangles},
            {"bytes", tile.bytes},
            {"xxh3", hex_digits(tile.checksum)}};
  }

  /// take(triangles): those of the cell, a batch at a time.
  template <class Take>
  void for_triangles(const Cell& cell, const Take& take) const {
    std::vector<CellTriangle> batch;
    for (const TrianglesByCell::Part& part : *cell.parts) {
      for (std::uint64_t done = 0; done < part.count; done += batch.size()) {
        runner_.stop.check();
        batch.resize(std::min<std::uint64_t>(kBatchRows, part.count - done));
        cut_.triangles.read(part.first + done, batch);
        take(batch);
      }
    }
  }

  void write_tile(Cell& cell) const {
    NumberSet numbers;
    WrittenTile& tile = cell.tile;
    for_triangles(cell, [&](std::span<const CellTriangle> batch) {
      tile.triangles += batch.size();
      for (const CellTriangle& triangle : batch)
        for (const std::uint64_t corner : triangle.corners) numbers.add(corner);
    });
    numbers.count_up();
    tile.vertices = numbers.count();
    const fs::path file = directory_ / file_of(cell);
    const auto writer = open_mesh_writer(
        file,
        {tile.vertices, tile.triangles, false, input_.header.has_hole, tile_schema(input_.header)},
        input_.options);
    write_vertices(numbers, *writer, tile.bounds);
    write_triangles(cell, numbers, *writer);
    writer->finish();
    tile.bytes = writer->bytes_written();
    tile.checksum = file_checksum(file);
    runner_.progress.advance(tile.triangles);
  }

  void write_vertices(const NumberSet& numbers, MeshWriter& writer, Box& bounds) const {
    PointCloud vertices;
    numbers.for_blocks([&](std::span<const std::uint64_t> block) {
      runner_.stop.check();
      cut_.vertices.load(block, vertices);
      bounds.extend(vertices.bounds());
      add_vertex_ids(input_.header, block, vertices);
      writer.write_vertices(vertices);
    });
  }

  void write_triangles(const Cell& cell, NumberSet& numbers, MeshWriter& writer) const {
    std::vector<Triangle64> triangles;
    std::vector<std::int32_t> hole;
    for_triangles(cell, [&](std::span<const CellTriangle> batch) {
      triangles.clear();
      hole.clear();
      for (const CellTriangle& triangle : batch) {
        const Triangle64& t = triangle.corners;
        triangles.push_back({numbers.rank(t[0]), numbers.rank(t[1]), numbers.rank(t[2])});
        if (input_.header.has_hole) hole.push_back(triangle.hole);
      }
      writer.write_triangles(triangles, hole);
    });
  }

  StageRunner& runner_;
  const TileInput& input_;
  const MapGrid& grid_;
  const CutMesh& cut_;
  fs::path directory_;
  std::vector<Cell> cells_;
};

}  // namespace

void check_tile_size(const Job& job) {
  if (job.output.tile_size == 0.0 || job.output.tiles) return;
  throw_usage("the size of tiles is given, and no tiles are asked for",
              {.file = job.output.mesh,
               .place = setting_name(job, "output.tile_size"),
               .found = format_exact(job.output.tile_size),
               .expected = "a job with tiles",
               .advice = "Add " + setting(job, "output.tiles", "true")});
}

std::uint64_t export_map_tiles(StageRunner& runner, const TileInput& input, SurfaceDigest& digest) {
  std::uint64_t bytes = 0;
  by_root(runner, [&] {
    TileDirectory target(final_target(tile_directory_of(runner.job.output.mesh)));
    const MapGrid grid(runner.job.output.tile_size);
    const std::unique_ptr<const CutMesh> cut = cut_by_map(runner, input, grid, digest);
    const std::uint64_t spooled = cut->vertices.bytes() + cut->triangles.bytes();
    runner.store.disk().add(spooled);
    MapTiles tiles(runner, input, grid, *cut, target.temporary());
    tiles.write();
    bytes = tiles.write_index(digest);
    target.commit();
    // The tiles stay, and are counted with the other outputs.
    runner.store.disk().add(bytes);
    runner.store.disk().remove(spooled + bytes);
  });
  return bytes;
}

}  // namespace orbweave
