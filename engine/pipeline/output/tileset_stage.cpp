#include "engine/pipeline/output/tileset_stage.h"

#include <atomic>
#include <string>

#include "engine/levels/tileset.h"
#include "engine/pipeline/output/mesh_for_levels.h"
#include "engine/pipeline/output/stored_nodes.h"
#include "io/meshes/mesh_stream.h"
#include "io/meshes/tile_directory.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "io/system/memory_watch.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// The progress of a stage with two parts: the mesh is read, then tiles are written, which takes
/// most of the time. Thread-safe.
class TilesetProgress {
 public:
  TilesetProgress(Progress& progress, std::uint64_t triangles)
      : progress_(progress), triangles_(triangles) {}

  void note_read(std::uint64_t triangles) {
    const std::uint64_t before = read_.fetch_add(triangles);
    progress_.advance((before + triangles) / kReadPart - before / kReadPart);
  }
  void plan(std::uint32_t tiles) { tiles_ = tiles; }
  void note_written() {
    const std::uint64_t before = written_.fetch_add(1);
    const std::uint64_t rest = triangles_ - triangles_ / kReadPart;
    progress_.advance(rest * (before + 1) / tiles_ - rest * before / tiles_);
  }

 private:
  static constexpr std::uint64_t kReadPart = 10;  ///< reading takes a tenth

  Progress& progress_;
  std::uint64_t triangles_;
  std::uint64_t tiles_ = 1;
  std::atomic<std::uint64_t> read_{0};
  std::atomic<std::uint64_t> written_{0};
};

TilesetOptions options_of(const TilesetInputs& inputs, StageRunner& runner) {
  const Partition& partition = inputs.partition;
  TilesetOptions options;
  options.levels.memory_bytes = runner.job.partition.memory_bytes;
  options.levels.threads = runner.threads();
  options.levels.directory = runner.store.directory();
  options.compression = runner.job.output.tileset_compression;
  options.coordinate_system = coordinate_system_beside(runner.job.output.mesh);
  options.up_axis = upright_axis(
      picture_up(runner.job, runner.job.files, partition.coordinate_system), partition.bounds);
  return options;
}

}  // namespace

void check_tileset(const Job& job) {
  const OutputOptions& output = job.output;
  if (output.tileset.empty()) return;
  check_mesh_for_levels(job, {"a tileset", "output.tileset", output.tileset,
                              "orbweave tileset MESH -o " + output.tileset});
  check_tile_directory(output.tileset);
}

void make_tileset(const TilesetInputs& inputs, StageRunner& runner) {
  const OutputOptions& output = runner.job.output;
  if (inputs.triangles == 0) {
    runner.warn("no tileset is made: the mesh has no triangle");
    return;
  }
  release_freed_memory(runner.job.partition.memory_bytes);
  StageClock clock(runner, Stage::kTileset, inputs.triangles, "triangles");
  StoredNodes nodes(runner.store, directory_of(Stage::kTileset));
  TilesetOptions options = options_of(inputs, runner);
  options.levels.nodes = &nodes;
  TilesetProgress progress(runner.progress, inputs.triangles);
  TilesetEvents events;
  events.read = [&](std::uint64_t triangles) { progress.note_read(triangles); };
  events.planned = [&](std::uint32_t tiles) { progress.plan(tiles); };
  events.written = [&] { progress.note_written(); };
  const auto mesh = open_mesh_stream(output.mesh);
  const TilesetFacts facts = write_tileset(*mesh, output.tileset, options, events, runner.stop);
  runner.store.finish_commits();
  clock.facts().bytes_written = facts.bytes;
  clock.facts().chunks = facts.tiles;
  clock.facts().chunks_reused = facts.reused;
  runner.store.disk().add(facts.bytes + facts.work_bytes);
  runner.store.disk().remove(facts.work_bytes);
  runner.note("tileset: " + format_count(facts.tiles) + (facts.tiles == 1 ? " tile" : " tiles") +
              " of " + format_count(facts.levels.size()) +
              (facts.levels.size() == 1 ? " level, " : " levels, ") + format_bytes(facts.bytes));
}

}  // namespace orbweave
