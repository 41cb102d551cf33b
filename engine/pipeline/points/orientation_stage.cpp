#include "engine/pipeline/points/orientation_stage.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>

#include "engine/normals/normal_side.h"
#include "engine/pipeline/stage/stage_begin.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "engine/spacing/orientation_cell.h"
#include "io/job/job_values.h"
#include "io/text/quantity.h"
#include "partition/allowed_threads.h"

namespace orbweave {
namespace {

/// The stage of the patches: their points are those of the cloud's stage, row by row.
constexpr const char* kPatchStage = directory_of(Stage::kPatches);
/// The stage that says which patches are turned, where several processes have to know.
constexpr const char* kTurnStage = directory_of(Stage::kTurns);

static_assert(sizeof(PatchSum) == 16 * 8 && sizeof(PatchVote) == 4 * 8,
              "stored as rows of 64-bit words");

void commit_patches(ChunkStore& store, ChunkId chunk, const OrientedPatches& patches) {
  const std::array<ArrayView, 4> arrays = {
      ArrayView{"patch_of", ScalarType::kUint64, 1, patches.patch_of.size(),
                patches.patch_of.data()},
      ArrayView{"turn", ScalarType::kUint8, 1, patches.turn.size(), patches.turn.data()},
      ArrayView{"sums", ScalarType::kUint64, 16, patches.sums.size(), patches.sums.data()},
      ArrayView{"votes", ScalarType::kUint64, 4, patches.votes.size(), patches.votes.data()}};
  store.commit(kPatchStage, chunk, arrays);
}

template <class T>
void append_all(const StoredResult& stored, const char* array, std::vector<T>& to) {
  const std::vector<T> rows = stored.read_all<T>(array);
  to.insert(to.end(), rows.begin(), rows.end());
}

/// The patches of all chunks in one graph.
PatchOrientation orient_graph(StageRunner& runner, const RawCloud& cloud,
                              const PatchGraphOptions& options) {
  StageClock clock(runner, Stage::kOrientation, 0, "patches");
  std::vector<PatchSum> sums;
  std::vector<PatchVote> votes;
  for (ChunkId chunk = 0; chunk < cloud.partition.octree.chunks().size(); ++chunk) {
    runner.stop.check();
    const auto stored = runner.store.open(kPatchStage, chunk);
    append_all(*stored, "sums", sums);
    append_all(*stored, "votes", votes);
  }
  runner.progress.advance(sums.size());
  tbb::task_arena arena(allowed_threads(runner.threads()));
  return arena.execute(
      [&] { return orient_patch_graph(std::move(sums), std::move(votes), options); });
}

/// For the members that are to turn normals as well.
void commit_turns(ChunkStore& store, const PatchOrientation& orientation) {
  const std::array<ArrayView, 2> arrays = {
      ArrayView{"patches", ScalarType::kUint64, 1, orientation.patches.size(),
                orientation.patches.data()},
      ArrayView{"turn", ScalarType::kUint8, 1, orientation.turn.size(), orientation.turn.data()}};
  store.begin_stage_anew(kTurnStage, "turns of this run");
  store.commit(kTurnStage, 0, arrays);
  store.finish_commits();
}

PatchOrientation load_turns(const ChunkStore& store) {
  const auto stored = store.open(kTurnStage, 0);
  PatchOrientation orientation;
  orientation.patches = stored->read_all<PatchId>("patches");
  orientation.turn = stored->read_all<std::uint8_t>("turn");
  return orientation;
}

}  // namespace

PatchOrientation orient_cloud(StageRunner& runner, const RawCloud& cloud, Orientation rule,
                              double spacing, double max_radius) {
  OrientationOptions options;
  options.cell = orientation_cell(spacing);
  options.max_radius = max_radius;
  options.among = cloud.partition.line_neighbors;
  options.stop = &runner.stop;
  by_root(runner, [&] {
    begin_stage(runner, kPatchStage,
                cloud.key + key_line("layout of patches", "5") +
                    key_line("cell of patches", format_exact(options.cell)) +
                    key_line("reach of patches", format_exact(options.max_radius)) +
                    key_line("neighbors of patches", std::to_string(options.among)));
  });
  require_points_for(runner, cloud, kPatchStage);
  visit_chunks(runner, cloud, kPatchStage, orientation_halo(options),
               [&](ChunkId chunk, PassPoints&& points) {
                 commit_patches(runner.store, chunk,
                                orient_patches(points.positions, points.normals, points.numbers(),
                                               points.begin, points.end, options));
               });
  PatchOrientation orientation;
  by_root(runner, [&] {
    orientation = orient_graph(runner, cloud, graph_options(rule, runner.job.normals, options));
    if (runner.communicator.size() > 1) commit_turns(runner.store, orientation);
  });
  if (!runner.communicator.is_root()) orientation = load_turns(runner.store);
  return orientation;
}

std::vector<std::uint8_t> turns_of_chunk(const ChunkStore& store, ChunkId chunk,
                                         const PatchOrientation& orientation) {
  const auto stored = store.open(kPatchStage, chunk);
  const auto patch_of = stored->read_all<PatchId>("patch_of");
  return whole_turns(patch_of, stored->read_all<std::uint8_t>("turn"), orientation);
}

}  // namespace orbweave
