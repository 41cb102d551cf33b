// The table of a job's stages, in their order. Everything that lists stages reads this table: keys,
// `--fresh`, status, repair of damage, progress, report and the benchmarks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/store/chunk_points.h"

namespace orbweave {

/// A stage by its place in the table. The stages from kRawCount to kTurns run on raw scans alone.
enum class Stage : std::uint8_t {
  kRawCount,
  kRawBin,
  kRawMeasure,
  kRawSort,
  kNoise,
  kQuality,
  kOutliers,
  kMerging,
  kSurfaceness,
  kNormals,
  kSmoothing,
  kThinning,
  kPatches,
  kOrientation,
  kTurns,
  kCount,
  kBin,
  kMeasure,
  kSort,
  kCells,
  kPowerCrust,
  kReconstruct,
  kStitch,
  kTrace,
  kHoles,
  kCheck,
  kSettle,
  kExport,
  kTiles,
  kPicture,
  kTileset,
  kSimplify,
};

/// Results of one kind that follow from each other: a stage whose key changed takes the results of
/// all later stages of its line with it.
enum class StageLine : std::uint8_t { kRaw, kFinal };

/// What is removed where a stored result of a stage is damaged.
enum class StageRepair : std::uint8_t {
  kChunk,        ///< the damaged chunk; it is computed again alone
  kStage,        ///< all results of the stage
  kStageAndCut,  ///< all results of the stage and the bins that they were sorted from
  kLine,         ///< the whole line, because the input of a complete pass is removed
};

/// Who does the work of a stage where several processes share a job.
enum class StageWork : std::uint8_t { kShared, kLeader, kRedundant };

/// How the time of a stage grows, for the forecast of a run and the models in bench/.
struct StageScaling {
  StageWork work = StageWork::kLeader;
  double threads = 0.0;        ///< share of the seconds that one process's threads divide
  bool constant = false;       ///< the seconds do not grow with the points
  double fixed_seconds = 0.0;  ///< of one thread, that do not grow with the points
  bool computes = false;       ///< the targets for threads hold for the stage
  double leader_share = 0.0;   ///< share of a shared stage that the leader does alone
  double merge_seconds = 0.0;  ///< to add what one process has to what another has
  double team_io = 0.0;        ///< times the stage's other bytes that only a team moves
  /// Typical microseconds of one core per point, on real scans (docs/results/scans.md). Of a stage
  /// whose time does not grow, as for a million points.
  double microseconds = 0.0;
};

struct StageInfo {
  Stage stage;
  const char* name;       ///< in progress, log, report and status
  const char* directory;  ///< of the work directory, with the results; empty: nothing is stored
  const char* results;    ///< what people call the results
  StageLine line;
  /// Whether the results go where an earlier stage of the line is made anew. Bins do not: the key
  /// of their stage is looked at when they are wanted.
  bool goes_with_line;
  bool dropped_by_fresh;
  StageRepair repair;
  bool shown_by_status;
  /// The document that says that the stage is complete, as a file; empty: the stage is complete
  /// when every chunk has a result.
  const char* completed_by;
  StageScaling scaling;
  int repeats = 1;  ///< most times that the stage runs; a number follows name and directory
};

inline constexpr StageScaling kCountScaling{
    .work = StageWork::kShared, .threads = 0.7, .merge_seconds = 0.02, .microseconds = 0.1};
inline constexpr StageScaling kBinScaling{
    .work = StageWork::kShared, .threads = 0.6, .team_io = 1.0, .microseconds = 0.2};
inline constexpr StageScaling kMeasureScaling{
    .threads = 0.9, .constant = true, .microseconds = 0.2};
inline constexpr StageScaling kSortScaling{
    .work = StageWork::kShared, .threads = 0.95, .team_io = 1.0, .microseconds = 0.2};
inline constexpr StageScaling kExportScaling{
    .work = StageWork::kShared, .threads = 0.9, .microseconds = 0.3};
/// The leader takes the checksum of all tiles.
inline constexpr StageScaling kTilesScaling{
    .work = StageWork::kShared, .threads = 0.5, .leader_share = 0.4, .microseconds = 0.3};
/// Of a stage whose chunks are computed independently.
constexpr StageScaling chunk_scaling(double microseconds) {
  return {
      .work = StageWork::kShared, .threads = 1.0, .computes = true, .microseconds = microseconds};
}

// clang-format off
inline constexpr std::array<StageInfo, 32> kStages = {{
    // stage, name, directory, results, line, goes with line, --fresh, repair, status, completed by
    {Stage::kRawCount, "raw count", "raw_cut", "counts of raw points", StageLine::kRaw, false, true,
     StageRepair::kStage, false, "", kCountScaling},
    {Stage::kRawBin, "raw bin", "raw_cut", "bins of raw points", StageLine::kRaw, false, true,
     StageRepair::kStage, false, "", kBinScaling},
    {Stage::kRawMeasure, "raw measure", "", "spacing of raw points", StageLine::kRaw, false, true,
     StageRepair::kStage, false, "", kMeasureScaling},
    {Stage::kRawSort, "raw sort", "raw", "raw points", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "partition.json", kSortScaling},
    {Stage::kNoise, "raw_noise", "raw_noise", "noise of places", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "", chunk_scaling(0.3)},
    {Stage::kQuality, "raw_quality", "raw_quality", "quality of points", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "ended.json", {.microseconds = 0.6}},
    {Stage::kOutliers, "raw_outliers", "raw_outliers", "outliers", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "ended.json", chunk_scaling(0.8)},
    {Stage::kMerging, "raw_merged", "raw_merged", "merged points", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "ended.json", {.microseconds = 0.3}},
    {Stage::kSurfaceness, "raw_surfaceness", "raw_surfaceness", "points of surfaces",
     StageLine::kRaw, true, true, StageRepair::kLine, true, "ended.json", chunk_scaling(1.0)},
    {Stage::kNormals, "raw_normals", "raw_normals", "normals", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "ended.json", chunk_scaling(1.0)},
    {Stage::kSmoothing, "raw_smooth", "raw_smooth", "smoothed points", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "ended.json", chunk_scaling(0.8), 8},
    {Stage::kThinning, "raw_thinned", "raw_thinned", "thinned points", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "ended.json", {.microseconds = 0.4}},
    {Stage::kPatches, "raw_patches", "raw_patches", "orientation", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "", {.microseconds = 0.5}},
    {Stage::kOrientation, "orient", "", "orientation", StageLine::kRaw, true, true,
     StageRepair::kLine, false, "",
     {.threads = 0.3, .fixed_seconds = 0.08, .microseconds = 0.15}},
    {Stage::kTurns, "raw_turns", "raw_turns", "orientation", StageLine::kRaw, true, true,
     StageRepair::kLine, true, "ended.json", {.microseconds = 0.1}},
    {Stage::kCount, "count", "points_cut", "counts of points", StageLine::kFinal, false, true,
     StageRepair::kStage, false, "", kCountScaling},
    {Stage::kBin, "bin", "points_cut", "bins of points", StageLine::kFinal, false, true,
     StageRepair::kStage, false, "", kBinScaling},
    {Stage::kMeasure, "measure", "", "spacing", StageLine::kFinal, false, true,
     StageRepair::kStage, false, "", kMeasureScaling},
    {Stage::kSort, "sort", kPointsStage, "points", StageLine::kFinal, true, true,
     StageRepair::kStageAndCut, true, "partition.json", kSortScaling},
    {Stage::kCells, "cells", "cells", "cells", StageLine::kFinal, true, true,
     StageRepair::kChunk, false, "", chunk_scaling(12.0)},
    {Stage::kPowerCrust, "power crust", "power_crust", "Power Crust", StageLine::kFinal, true, true,
     StageRepair::kStage, true, "", {.work = StageWork::kShared, .microseconds = 56.0}},
    {Stage::kReconstruct, "reconstruct", "mesh", "mesh", StageLine::kFinal, true, true,
     StageRepair::kChunk, true, "", chunk_scaling(0.6)},
    {Stage::kStitch, "stitch", "stitch", "mesh", StageLine::kFinal, true, true,
     StageRepair::kStage, false, "", {.microseconds = 0.1}},
    {Stage::kTrace, "trace", "", "boundary loops", StageLine::kFinal, false, true,
     StageRepair::kStage, false, "", {.work = StageWork::kRedundant, .microseconds = 0.1}},
    {Stage::kHoles, "holes", "holes", "holes", StageLine::kFinal, true, true,
     StageRepair::kChunk, true, "", {.work = StageWork::kShared, .threads = 1.0, .microseconds = 0.5}},
    {Stage::kCheck, "check", "crossings", "crossings", StageLine::kFinal, true, true,
     StageRepair::kChunk, false, "", chunk_scaling(0.3)},
    {Stage::kSettle, "settle", "settled", "holes", StageLine::kFinal, true, true,
     StageRepair::kStage, false, "", {.microseconds = 0.0}},
    {Stage::kExport, "export", "export", "mesh file", StageLine::kFinal, false, false,
     StageRepair::kStage, false, "", kExportScaling},
    {Stage::kTiles, "export", "tiles", "tiles", StageLine::kFinal, false, false,
     StageRepair::kStage, false, "", kTilesScaling},
    {Stage::kPicture, "picture", "", "picture", StageLine::kFinal, false, false,
     StageRepair::kStage, false, "", {.threads = 0.5, .constant = true, .microseconds = 1.0}},
    {Stage::kTileset, "tileset", "tileset", "tileset", StageLine::kFinal, true, true,
     StageRepair::kChunk, false, "", {.threads = 0.9, .microseconds = 11.0}},
    {Stage::kSimplify, "simplify", "simplify", "simplified mesh", StageLine::kFinal, true, true,
     StageRepair::kChunk, false, "", {.threads = 0.8, .microseconds = 12.0}},
}};
// clang-format on

constexpr bool stages_are_in_order() {
  for (std::size_t i = 0; i < kStages.size(); ++i)
    if (kStages[i].stage != static_cast<Stage>(i)) return false;
  return true;
}
static_assert(stages_are_in_order(), "a stage's value is its place in the table");

constexpr const StageInfo& info_of(Stage stage) { return kStages[static_cast<std::size_t>(stage)]; }
constexpr const char* name_of(Stage stage) { return info_of(stage).name; }
constexpr const char* directory_of(Stage stage) { return info_of(stage).directory; }

/// The directory of a stage that runs several times: "raw_smooth_1" for the first.
std::string directory_of(Stage stage, int repeat);

inline constexpr const char* kCellStage = directory_of(Stage::kCells);
inline constexpr const char* kPowerCrustStage = directory_of(Stage::kPowerCrust);
inline constexpr const char* kMeshStage = directory_of(Stage::kReconstruct);
inline constexpr const char* kStitchStage = directory_of(Stage::kStitch);
inline constexpr const char* kHoleStage = directory_of(Stage::kHoles);
inline constexpr const char* kCheckStage = directory_of(Stage::kCheck);
inline constexpr const char* kSettledStage = directory_of(Stage::kSettle);

/// The stage whose results lie in a directory; null where the table has no such directory. Of
/// several stages with one directory, the first.
const StageInfo* stage_in(std::string_view directory);

/// The directories of a line whose results go with it, in the order of the table.
std::vector<std::string> directories_of(StageLine line);

/// `directory` and all later ones of its line.
std::vector<std::string> directories_from(std::string_view directory);

/// All directories of the raw line, bins included.
std::vector<std::string> raw_directories();

/// What `--fresh` drops.
std::vector<std::string> directories_dropped_by_fresh();

/// Removes what the stages on raw scans left in the store.
void discard_raw_stages(ChunkStore& store);

/// The stages that cut a cloud into chunks.
struct CutStages {
  Stage count;
  Stage bin;
  Stage measure;
  Stage sort;

  /// Of the store, with the sorted points.
  const char* points() const { return directory_of(sort); }
  /// Of the store, with counts and bins.
  const char* cut() const { return directory_of(bin); }
};
inline constexpr CutStages kRawCut{Stage::kRawCount, Stage::kRawBin, Stage::kRawMeasure,
                                   Stage::kRawSort};
inline constexpr CutStages kFinalCut{Stage::kCount, Stage::kBin, Stage::kMeasure, Stage::kSort};

}  // namespace orbweave
