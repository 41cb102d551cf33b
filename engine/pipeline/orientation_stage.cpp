#include "engine/pipeline/orientation_stage.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/pipeline/stage_keys.h"
#include "io/job_values.h"
#include "io/quantity.h"

namespace orbweave {
namespace {

/// A cell of so many spacings holds some 150 to 600 points of a surface.
constexpr double kCellPerSpacing = 12.0;

static_assert(sizeof(PatchSum) == 15 * 8 && sizeof(PatchVote) == 4 * 8,
              "stored as rows of 64-bit words");

/// The least power of two that is not below; the same on every machine, as logarithms are not.
double power_of_two_above(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return std::ldexp(1.0, mantissa == 0.5 ? exponent - 1 : exponent);
}

void commit_patches(ChunkStore& store, ChunkId chunk, const OrientedPatches& patches) {
  const std::array<ArrayView, 4> arrays = {
      ArrayView{"patch_of", ScalarType::kUint64, 1, patches.patch_of.size(),
                patches.patch_of.data()},
      ArrayView{"turn", ScalarType::kUint8, 1, patches.turn.size(), patches.turn.data()},
      ArrayView{"sums", ScalarType::kUint64, 15, patches.sums.size(), patches.sums.data()},
      ArrayView{"votes", ScalarType::kUint64, 4, patches.votes.size(), patches.votes.data()}};
  store.commit(kPatchStage, chunk, arrays);
}

template <class T>
void append_all(const StoredResult& stored, const char* array, std::vector<T>& to) {
  const std::vector<T> rows = stored.read_all<T>(array);
  to.insert(to.end(), rows.begin(), rows.end());
}

/// The patches of all chunks in one graph.
PatchOrientation orient_graph(JobContext& context, const RawCloud& cloud) {
  StageClock clock(context, "orient", 0, "patches");
  std::vector<PatchSum> sums;
  std::vector<PatchVote> votes;
  for (ChunkId chunk = 0; chunk < cloud.partition.octree.chunks().size(); ++chunk) {
    const auto stored = context.store.open(kPatchStage, chunk);
    append_all(*stored, "sums", sums);
    append_all(*stored, "votes", votes);
  }
  return orient_patch_graph(std::move(sums), std::move(votes));
}

/// For the members that are to turn normals as well.
void commit_turns(ChunkStore& store, const PatchOrientation& orientation) {
  const std::array<ArrayView, 2> arrays = {
      ArrayView{"patches", ScalarType::kUint64, 1, orientation.patches.size(),
                orientation.patches.data()},
      ArrayView{"turn", ScalarType::kUint8, 1, orientation.turn.size(), orientation.turn.data()}};
  store.discard_stage(kTurnStage);
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

PatchOrientation orient_cloud(JobContext& context, const RawCloud& cloud, double spacing,
                              double max_radius) {
  OrientationOptions options;
  options.cell = power_of_two_above(kCellPerSpacing * spacing);
  options.max_radius = max_radius;
  by_leader(context, [&] {
    begin_stage(context, kPatchStage,
                cloud.key + key_line("layout of patches", "1") +
                    key_line("cell of patches", format_exact(options.cell)) +
                    key_line("reach of patches", format_exact(options.max_radius)));
  });
  visit_chunks(context, cloud, kPatchStage, orientation_halo(options),
               [&](ChunkId chunk, PassPoints&& points) {
                 commit_patches(context.store, chunk,
                                orient_patches(points.positions, points.normals, points.global,
                                               points.begin, points.end, options));
               });
  PatchOrientation orientation;
  by_leader(context, [&] {
    orientation = orient_graph(context, cloud);
    if (context.team.size() > 1) commit_turns(context.store, orientation);
  });
  if (!context.team.leads()) orientation = load_turns(context.store);
  return orientation;
}

std::vector<std::uint8_t> turns_of_chunk(const ChunkStore& store, ChunkId chunk,
                                         const PatchOrientation& orientation) {
  const auto stored = store.open(kPatchStage, chunk);
  const auto patch_of = stored->read_all<PatchId>("patch_of");
  std::vector<std::uint8_t> turns = stored->read_all<std::uint8_t>("turn");
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const auto at =
        std::lower_bound(orientation.patches.begin(), orientation.patches.end(), patch_of[i]);
    if (at == orientation.patches.end() || *at != patch_of[i]) continue;
    turns[i] ^= orientation.turn[static_cast<std::size_t>(at - orientation.patches.begin())];
  }
  return turns;
}

}  // namespace orbweave
