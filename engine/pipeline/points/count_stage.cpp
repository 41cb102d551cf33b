#include "engine/pipeline/points/count_stage.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/points/dense_chunks.h"
#include "engine/pipeline/points/own_share.h"
#include "engine/pipeline/points/selection_facts.h"
#include "engine/pipeline/points/stray_search.h"
#include "engine/pipeline/points/trajectory_facts.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/spacing/automatic_radii.h"
#include "engine/validation/usable_scale.h"
#include "io/bounds.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/points/color_depth.h"
#include "io/points/point_views.h"

namespace orbweave {
namespace {

void add_counts(DroppedPoints& to, const DroppedPoints& from) {
  for (const auto& [reason, count] : from) to[reason] += count;
}

/// A chunk of a surface whose side is 48 halos computes a twelfth more for its halo. (An octree
/// halves sides, so that half as many halos per side are usual: a sixth more.) Threads need no more
/// chunks than that: they share the work on one.
constexpr double kHalosPerSide = 48.0;

/// The widest halo of the passes over raw points, that of patches of one orientation.
constexpr double kRawHaloSpacings = 16.0;

/// How many raw points a chunk needs so that its halo is not most of the work. Reading, writing and
/// sorting of a chunk keep one thread busy: all threads are where there are several chunks.
std::uint64_t worthwhile_raw_points(std::uint64_t points) {
  constexpr double kSide = kHalosPerSide * kRawHaloSpacings;
  return std::min(static_cast<std::uint64_t>(kSide * kSide), points);
}

/// How many points a chunk needs so that its halo is not most of the work: the points of a piece
/// of surface of that side. The surface is guessed from the cells that hold points.
std::uint64_t worthwhile_chunk_points(const CountGrid& grid, const ReconstructOptions& options,
                                      const std::vector<double>& likely_radii) {
  if (options.ball_radii.empty()) {
    // Automatic radii are so many spacings; a spacing squared holds a point. Where their number
    // follows from the density, too, chunks are put together once that is known.
    std::vector<double> radii = likely_radii;
    if (radii.empty()) radii = {kRadiusPerSpacing};
    for (int level = static_cast<int>(radii.size()); level < options.levels; ++level)
      radii.push_back(radii.back() * kRadiusGrowth);
    return worthwhile_points(radii, 1.0, grid.points());
  }
  std::uint64_t cells = 0;
  grid.for_each([&](Vec3, std::uint64_t) { ++cells; });
  const double points_per_area =
      static_cast<double>(grid.points()) / (static_cast<double>(cells) * grid.cell() * grid.cell());
  return worthwhile_points(options.ball_radii, points_per_area, grid.points());
}

/// The least budget of all stages that the job will run, before any of them: estimated normals make
/// points larger than they are read.
void require_budget(const ResolvedJob& job, PointSchema scans) {
  scans.has_normals = scans.has_normals || job.needs_cleaning_or_normals();
  job.memory_plan(0, scans);
}

/// What the points may take in memory from the first pass to the second: a fraction of what is left
/// beside what reading takes.
std::size_t bytes_to_remember(const RunControl& control, const PointSchema& schema) {
  constexpr std::size_t kPart = 4;
  const std::size_t taken =
      MemoryCosts::kBaseBytes + MemoryCosts::stream_bytes(schema, control.threads());
  const std::size_t budget = control.job.partition.memory_bytes;
  return budget > taken ? (budget - taken) / kPart : 0;
}

using Share = std::function<std::unique_ptr<PointSource>(std::unique_ptr<PointSource>)>;

/// First pass over the rows that `share` leaves.
CountedCloud count_share(const RunControl& control, const CloudInput& input, const Share& share,
                         const PointFilter& filter, bool remembers) {
  CountedCloud cloud;
  cloud.filter = filter;
  const auto source = share(input.open(&cloud.notes));
  cloud.schema = source->schema();
  if (input.are_scans) require_budget(control.job, cloud.schema);
  cloud.coordinate_system = source->coordinate_system();
  cloud.meters_per_unit = source->meters_per_unit();
  if (remembers) cloud.remembered = RememberedPoints(bytes_to_remember(control, cloud.schema));
  const bool has_view = view_offset(cloud.schema).has_value();
  const std::optional<WideColors> colors = wide_colors(cloud.schema);
  const auto look = [&](StreamBatch& batch) {
    if (input.are_scans) batch.bounds = bounds_of(batch.points.positions);
  };
  stream_points(
      *source, {.threads = control.threads(), .stop = &control.stop, .filter = &filter}, look,
      [&](StreamBatch& batch) {
        cloud.grid.add(batch.points.positions);
        if (input.are_scans)
          cloud.extents.add(batch.scan, {batch.points.size(), batch.bounds, batch.scanner});
        if (colors && !cloud.has_wide_colors)
          cloud.has_wide_colors = exceed_8_bits(batch.points, *colors);
        cloud.points_read += batch.points_read;
        add_origin_counts(cloud.at_scan_origins, batch.at_scan_origins);
        if (has_view) cloud.points_without_view += count_without_view(batch.points);
        add_counts(cloud.dropped, batch.dropped);
        control.progress.advance(batch.points_read);
        control.progress.add_points(batch.points_read);
        cloud.remembered.take(batch.points, batch.scan);
      });
  for (const auto& [reason, count] : source->left_out()) cloud.rows_left_out += count;
  cloud.points_read += cloud.rows_left_out;
  cloud.own_share = cloud.points_read;
  add_counts(cloud.dropped, source->left_out());
  cloud.bytes_read = source->bytes_read();
  if (!has_view) cloud.points_without_view = cloud.grid.points();
  return cloud;
}

/// Normals that are no normals are no reason to do without the points.
std::string advice_on_unusable(const ResolvedJob& job, const DroppedPoints& dropped) {
  const auto are_of = [&](DropReason reason) { return dropped.contains(text_of(reason)); };
  if (!are_of(DropReason::kZeroNormal) && !are_of(DropReason::kNormalNotFinite)) return {};
  return "Try " + setting(job, "normals.source", "estimate");
}

[[noreturn]] void refuse_empty(const RunControl& control, const CountedCloud& cloud) {
  const ResolvedJob& job = control.job;
  if (cloud.points_read == 0)
    throw_bad_input("the cloud holds no points", {.file = job.files.front()});
  if (has_selected(job, cloud.dropped)) refuse_empty_selection(control, cloud);
  throw_bad_input("the cloud holds no usable point",
                  {.file = job.files.front(),
                   .found = describe_dropped(cloud.points_read, cloud.dropped),
                   .advice = advice_on_unusable(job, cloud.dropped)});
}

/// Poles are found among all raw points at once.
bool is_one_chunk(const ResolvedJob& job, const CloudInput& input) {
  return job.normals.source == NormalSource::kPoles && is_cut_again(input);
}

/// Every process is to have several chunks.
void plan_cut(const RunControl& control, const CloudInput& input, CountedCloud& cloud,
              int processes) {
  const ResolvedJob& job = control.job;
  cloud.points_used = cloud.grid.points();
  if (input.are_scans) require_fitting_trajectory(control, cloud);
  if (cloud.points_used == 0) refuse_empty(control, cloud);
  if (input.are_scans) cloud.doubts = objections_to_extents(job, cloud.extents);
  require_usable_scale(job.files.front(), "cloud", cloud.grid.bounds());
  require_memory_for_method(job, cloud.points_used);
  if (input.are_scans) require_memory_for_poles(job, cloud.points_used);
  cloud.grid.settle(root_cube(cloud.grid.bounds()).side);
  const std::uint64_t worthwhile =
      is_cut_again(input)
          ? worthwhile_raw_points(cloud.points_used)
          : worthwhile_chunk_points(cloud.grid, job.reconstruct, input.likely_radii);
  cloud.memory = job.memory_plan(cloud.points_used / static_cast<std::uint64_t>(processes),
                                 cloud.schema, worthwhile);
  if (is_in_core(job.reconstruct.method) && goes_in_chunks(job, cloud.points_used))
    cloud.memory.chunk_points = super_cocone_chunk_points(job);
  if (is_one_chunk(job, input)) cloud.memory.chunk_points = kOneChunkPoints;
  const std::uint64_t wanted = job.partition.chunk_points;
  if (cloud.memory.chunk_points < wanted) {
    cloud.notes.push_back(setting(job, "partition.chunk_points", std::to_string(wanted)) +
                          " is more than the memory budget has room for; chunks get " +
                          std::to_string(cloud.memory.chunk_points) + " points");
  }
}

void cut_chunks(const RunControl& control, const CloudInput& input, CountedCloud& cloud) {
  cloud.octree = cut_octree(cloud.grid, root_cube(cloud.grid.bounds()), cloud.memory.chunk_points);
  split_dense_chunks(control, input, cloud);
  constexpr std::size_t kMostChunks = 64;
  const std::size_t chunks = cloud.octree.chunks().size();
  const bool is_free = control.job.partition.chunk_points == 0 && !is_cut_again(input);
  if (is_free && chunks > 1 && chunks <= kMostChunks)
    cloud.places = crowded_places(cloud.grid, cloud.octree.root());
}

}  // namespace

bool is_cut_again(const CloudInput& input) { return input.stages.points() == kRawCut.points(); }

std::uint64_t worthwhile_points(const std::vector<double>& radii, double points_per_area,
                                std::uint64_t points) {
  const double side = kHalosPerSide * halo_width(radii);
  return static_cast<std::uint64_t>(
      std::min(side * side * points_per_area, static_cast<double>(points)));
}

CountedCloud count_points(const RunControl& control, const CloudInput& input) {
  const Share all = [](std::unique_ptr<PointSource> source) { return source; };
  CountedCloud cloud = count_without_strays(control.job, input, [&](const PointFilter& filter) {
    return count_share(control, input, all, filter, false);
  });
  plan_cut(control, input, cloud, 1);
  cut_chunks(control, input, cloud);
  return cloud;
}

CountedCloud count_by_team(const CloudInput& input, const CutExchange& cut, StageRunner& runner) {
  StageClock clock(runner, input.stages.count, 0, "points");
  const Share own = [&](std::unique_ptr<PointSource> source) {
    return own_share(std::move(source), runner.communicator);
  };
  CountedCloud cloud = count_without_strays(runner.job, input, [&](const PointFilter& filter) {
    // Members of a team may be given other rows the second time; a store is quickly read again.
    const bool remembers = runner.communicator.size() == 1 && input.are_scans;
    return whole_cloud(count_share(runner, input, own, filter, remembers), cut, runner);
  });
  plan_cut(runner, input, cloud, runner.communicator.size());
  if (runner.communicator.is_root()) cut_chunks(runner, input, cloud);
  // Chunks are what several processes share.
  if (runner.communicator.size() > 1) cloud.places.clear();
  cloud.bounds = cloud.grid.bounds();
  clock.facts().points = cloud.points_read;
  // The store counts what cleaned points are read from.
  if (input.are_scans && runner.communicator.is_root()) clock.facts().bytes_read = cloud.bytes_read;
  return cloud;
}

}  // namespace orbweave
