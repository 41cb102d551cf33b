#include "engine/pipeline/budget/time_forecast.h"

#include <algorithm>
#include <array>

#include "engine/ball_pivoting/halo_width.h"
#include "engine/normals/normal_side.h"
#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/stage/stages.h"
#include "io/report/reasons.h"

namespace orbweave {
namespace {

/// What the points cost that a first radius leaves open, at each further one, of the first one's
/// time: a few points, each of them with many neighbours.
constexpr double kFurtherRadius = 3.2;
/// Times what tiles by chunk take: docs/results/formats.md.
constexpr double kMapTiles = 3.4;
/// Levels that automatic radii have on most scans.
constexpr std::size_t kTypicalRadii = 3;
/// Core seconds of a loop, large ones among small ones.
constexpr double kSecondsPerLoop = 0.0006;
/// Of the time of a stage whose time grows no further.
constexpr double kConstantPoints = 1e6;
/// What compressing adds to a stage that writes points or triangles, in microseconds per point
/// (docs/disk.md).
constexpr double kCompression = 0.3;

bool is_written(Stage stage) {
  return stage == Stage::kRawSort || stage == Stage::kSort || stage == Stage::kReconstruct;
}

/// Whether normals may be oriented by propagation: what the scans tell of scanners decides.
bool may_propagate(const ResolvedJob& job) {
  return job.estimates_normals &&
         (job.normals.orientation == Orientation::kAuto || is_propagated(job.normals.orientation));
}

/// Whether Super Cocone takes the points in chunks.
bool is_super(const ResolvedJob& job, const JobSize& size) {
  return is_cocone(job.reconstruct.method) && goes_in_chunks(job, size.kept_points);
}

/// How often the job runs the stage; of stages that a measurement decides about, how often at most.
int runs_of(const ResolvedJob& job, const JobSize& size, Stage stage) {
  const CleaningOptions& cleaning = job.cleaning;
  const bool may_clean = cleaning.automatic;
  switch (stage) {
    case Stage::kOutliers:
      return may_clean || cleaning.outlier_sigma > 0.0 || cleaning.cluster_points.value_or(0) > 0
                 ? 1
                 : 0;
    case Stage::kNoise:
      return may_clean || job.output.vertex_quality ? 1 : 0;
    case Stage::kQuality:
      return job.output.vertex_quality ? 1 : 0;
    case Stage::kSurfaceness:
      return cleaning.min_surfaceness > 0.0 ? 1 : 0;
    case Stage::kMerging:
      return cleaning.merge_tolerance > 0.0 ? 1 : 0;
    case Stage::kNormals:
      return job.estimates_normals ? 1 : 0;
    case Stage::kSmoothing:
      return may_clean || cleaning.smooth_radius > 0.0 ? cleaning.smooth_passes : 0;
    case Stage::kThinning:
      return may_clean || cleaning.thin_to_spacing > 0.0 ? 1 : 0;
    case Stage::kCells:
      return is_super(job, size) ? 1 : 0;
    case Stage::kPowerCrust:
      return has_own_vertices(job.reconstruct.method) ? 1 : 0;
    case Stage::kHoles:
    case Stage::kTrace:
    case Stage::kSettle:
      return job.fill.enabled ? 1 : 0;
    case Stage::kCheck:
      return job.fill.enabled || job.output.check_surface ? 1 : 0;
    case Stage::kPatches:
    case Stage::kOrientation:
    case Stage::kTurns:
      return may_propagate(job) ? 1 : 0;
    case Stage::kExport:
      return job.output.tiles ? 0 : 1;
    case Stage::kTiles:
      return job.output.tiles ? 1 : 0;
    case Stage::kPicture:
      return job.output.picture.empty() ? 0 : 1;
    case Stage::kTileset:
      return job.output.tileset.empty() ? 0 : 1;
    case Stage::kSimplify:
      return job.output.simplify ? 1 : 0;
    default:
      return info_of(stage).line == StageLine::kFinal || job.needs_cleaning_or_normals() ? 1 : 0;
  }
}

/// The count of radii that is known or typical.
std::size_t radii_of(const ResolvedJob& job, const JobSize& size) {
  if (size.radii > 0) return size.radii;
  return job.reconstruct.ball_radii.empty() ? kTypicalRadii : job.reconstruct.ball_radii.size();
}

/// Tiles on a map grid are the leader's work.
bool is_cut_by_map(const ResolvedJob& job, const StageInfo& stage) {
  return stage.stage == Stage::kTiles && job.output.tile_size > 0.0;
}

double microseconds_of(const ResolvedJob& job, const JobSize& size, const StageInfo& stage) {
  double microseconds = stage.scaling.microseconds;
  if (stage.stage == Stage::kReconstruct)
    microseconds *= 1.0 + kFurtherRadius * static_cast<double>(radii_of(job, size) - 1);
  if (is_cut_by_map(job, stage)) microseconds *= kMapTiles;
  if (job.run.compress && is_written(stage.stage)) microseconds += kCompression;
  return microseconds;
}

double seconds_of(const ResolvedJob& job, const JobSize& size, const StageInfo& stage) {
  const StageScaling& scaling = stage.scaling;
  double points =
      static_cast<double>(stage.line == StageLine::kRaw ? size.points : size.kept_points);
  const MethodCosts costs = costs_of(job.reconstruct.method);
  const bool makes_vertices = has_own_vertices(job.reconstruct.method);
  if (stage.stage == Stage::kPowerCrust) return 1e-6 * costs.microseconds_per_point * points;
  if (stage.line == StageLine::kFinal && stage.stage >= Stage::kReconstruct)
    points *= costs.vertices_per_point;
  if (scaling.constant) points = std::min(points, kConstantPoints);
  if (stage.stage == Stage::kReconstruct && is_in_core(job.reconstruct.method) && !makes_vertices &&
      !is_super(job, size))
    return 1e-6 * costs.microseconds_per_point * points;
  if (stage.stage == Stage::kNormals && job.normals.source == NormalSource::kPoles)
    return 1e-6 * costs_of(job.normals.source).microseconds_per_point * points;
  double seconds = 1e-6 * microseconds_of(job, size, stage) * points;
  if (stage.stage == Stage::kReconstruct && !is_in_core(job.reconstruct.method))
    seconds *= size.halo_work;
  if (stage.stage == Stage::kCells) seconds *= kCoconeBoxesPerChunk;
  if (stage.stage == Stage::kHoles && size.loops)
    seconds = kSecondsPerLoop * static_cast<double>(*size.loops);
  seconds *= 1.0 - scaling.threads + scaling.threads / job.threads();
  const bool is_shared = scaling.work == StageWork::kShared && !is_cut_by_map(job, stage);
  return is_shared ? seconds / size.processes : seconds;
}

double halo_work_of(const Partition& partition, std::span<const double> radii) {
  if (radii.empty() || partition.points() == 0) return 1.0;
  double points = 0.0;
  for (const std::uint64_t of_chunk : expected_points_with_halos(partition, halo_width(radii)))
    points += static_cast<double>(of_chunk);
  return std::max(1.0, points / static_cast<double>(partition.octree.points()));
}

}  // namespace

std::vector<ExpectedStage> expected_stages(const ResolvedJob& job, const JobSize& size) {
  std::vector<ExpectedStage> stages;
  for (const StageInfo& stage : kStages) {
    const int runs = runs_of(job, size, stage.stage);
    for (int run = 1; run <= runs; ++run)
      stages.push_back({stage.repeats > 1 ? directory_of(stage.stage, run) : stage.name,
                        seconds_of(job, size, stage)});
  }
  return stages;
}

JobSize size_of_job(const Partition& partition, std::span<const double> radii, int processes) {
  constexpr std::array kDroppedByStages = {DropReason::kDuplicate,       DropReason::kOutlier,
                                           DropReason::kMerged,          DropReason::kThinned,
                                           DropReason::kTooFewNeighbors, DropReason::kCluster,
                                           DropReason::kNoSurface};
  std::uint64_t points = partition.points();
  for (const DropReason reason : kDroppedByStages) {
    const auto dropped = partition.dropped.find(text_of(reason));
    if (dropped != partition.dropped.end()) points += dropped->second;
  }
  return {points,       partition.points(), radii.size(),
          std::nullopt, processes,          halo_work_of(partition, radii)};
}

double sum_of_seconds(std::span<const ExpectedStage> stages) {
  double sum = 0.0;
  for (const ExpectedStage& stage : stages) sum += stage.seconds;
  return sum;
}

}  // namespace orbweave
