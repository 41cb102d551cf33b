#include "engine/pipeline/partition_stage.h"

#include <algorithm>
#include <cstring>

#include "engine/ball_pivoting/automatic_radii.h"
#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/cut_exchange.h"
#include "engine/pipeline/dense_chunks.h"
#include "engine/pipeline/disk_plan.h"
#include "engine/pipeline/prepare_stage.h"
#include "engine/pipeline/stage_keys.h"
#include "io/chunk_points.h"
#include "io/error.h"
#include "io/scan_source.h"
#include "partition/binning.h"
#include "partition/canonical_order.h"
#include "partition/count_grid.h"
#include "partition/memory_plan.h"

namespace orbweave {
namespace {

constexpr const char* kDocument = "partition";
/// How the points are cut, while they are being sorted.
constexpr const char* kCutDocument = "cut";

/// Rows of the files that held no wanted point were read as well.
void add_left_out(const PointSource& source, std::uint64_t& points_read) {
  for (const auto& [reason, count] : source.left_out()) points_read += count;
}

void add_counts(DroppedPoints& to, const DroppedPoints& from) {
  for (const auto& [reason, count] : from) to[reason] += count;
}

/// Points whose scanner is not known.
std::uint64_t count_without_view(const PointCloud& points) {
  const std::optional<std::size_t> offset = view_offset(points.schema);
  if (!offset) return points.size();
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    ViewCode code;
    std::memcpy(&code, points.attribute_row(i).data() + *offset, sizeof code);
    count += code.known() ? 0 : 1;
  }
  return count;
}

std::string no_points_reason(const DroppedPoints& dropped) {
  std::string text = "no usable point";
  for (const auto& [reason, count] : dropped)
    text += "; " + std::to_string(count) + " dropped: " + reason;
  return text;
}

/// A chunk whose side is eight halos computes about half as much again for its halo.
constexpr double kHalosPerSide = 8.0;

/// A side of so many halos.
std::uint64_t worthwhile_points(const std::vector<double>& radii, double points_per_area,
                                std::uint64_t points) {
  const double side = kHalosPerSide * halo_width(radii);
  return static_cast<std::uint64_t>(
      std::min(side * side * points_per_area, static_cast<double>(points)));
}

/// How many points a chunk needs so that its halo is not most of the work: the points of a piece
/// of surface of that side. The surface is guessed from the cells that hold points.
std::uint64_t worthwhile_chunk_points(const CountGrid& grid, const ReconstructOptions& options) {
  if (options.ball_radii.empty()) {
    // Automatic radii are so many spacings; a spacing squared holds a point. Where their number
    // follows from the density, too, chunks are put together once that is known.
    std::vector<double> radii = {kRadiusPerSpacing};
    for (int level = 1; level < options.levels; ++level)
      radii.push_back(radii.back() * kRadiusGrowth);
    return worthwhile_points(radii, 1.0, grid.points());
  }
  std::uint64_t cells = 0;
  grid.for_each([&](Vec3, std::uint64_t) { ++cells; });
  const double points_per_area =
      static_cast<double>(grid.points()) / (static_cast<double>(cells) * grid.cell() * grid.cell());
  return worthwhile_points(options.ball_radii, points_per_area, grid.points());
}

/// Second pass: every point of the member's share goes to the bin of its chunk.
void bin_points(JobContext& context, const CloudInput& input, const CountedCloud& cloud,
                std::uint64_t share, Binner& binner, SpacingSampler& sampler) {
  const auto source = own_share(input.open(nullptr), context.team);
  StageClock clock(context, input.prefix + "bin", share, "points");
  std::uint64_t points_read = 0;
  stream_points(
      *source, {.threads = context.threads(), .stop = &context.stop},
      [&](StreamBatch& batch) {
        batch.chunks.resize(batch.points.size());
        for (std::size_t i = 0; i < batch.points.size(); ++i) {
          batch.chunks[i] = cloud.octree.chunk_of(batch.points.positions[i]);
        }
      },
      [&](StreamBatch& batch) {
        binner.add(batch.points, batch.chunks);
        sampler.add(batch.points.positions);
        points_read += batch.points_read;
        context.progress.advance(batch.points_read);
        context.progress.add_points(batch.points_read);
      });
  add_left_out(*source, points_read);
  if (points_read != share) {
    throw_bad_input("the input changed while it was read",
                    {.file = context.files.front(),
                     .place = {},
                     .found = std::to_string(points_read) + " points",
                     .expected = std::to_string(share),
                     .advice = "Run the same command again"});
  }
  clock.facts().points = points_read;
  clock.facts().bytes_read = source->bytes_total();
  clock.facts().bytes_written = binner.spilled_bytes();
}

/// Chunks that an earlier run sorted are taken where it had cut the points in the same way.
void keep_what_is_sorted(JobContext& context, const std::string& stage,
                         const Partition& partition) {
  Partition cut;
  cut.schema = partition.schema;
  cut.octree = partition.octree;
  const std::string text = partition_to_json(cut);
  if (context.store.document(stage, kCutDocument) == text) return;
  context.store.discard_results(stage);
  context.store.commit_document(stage, kCutDocument, text);
}

/// Sorts every chunk canonically and commits it.
void sort_chunks(JobContext& context, const CloudInput& input, const CountedCloud& cloud,
                 BinSource& bins, const Partition& partition) {
  const auto& chunks = partition.octree.chunks();
  by_leader(context, [&] { keep_what_is_sorted(context, input.stage, partition); });
  StageClock clock(context, input.prefix + "sort", chunks.size(), "chunks");
  std::vector<ChunkWork> tasks;
  const std::uint64_t most = most_sorted_points(cloud.memory, cloud.schema);
  for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk) {
    const std::uint64_t points = std::min(chunks[chunk].points, 2 * most);
    tasks.push_back({chunk, points * MemoryCosts::sort_bytes(cloud.schema), chunks[chunk].points,
                     chunks[chunk].points});
  }
  share_chunks(context, clock, input.stage, std::move(tasks),
               cloud.memory.chunks_in_flight_bytes / 2, [&](ChunkId chunk) {
                 commit_points(context.store, chunk,
                               take_sorted(bins, cloud.octree, chunks[chunk], most).points,
                               input.stage);
               });
  clock.facts().points = cloud.points_used;
}

/// Numbers the points that are left once duplicates are merged.
void number_points(JobContext& context, const std::string& stage, const CountedCloud& cloud,
                   Partition& partition) {
  partition.first_vertex.assign(1, 0);
  for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk) {
    partition.first_vertex.push_back(partition.first_vertex.back() +
                                     stored_points(context.store, chunk, stage));
  }
  const std::uint64_t merged = cloud.points_used - partition.points();
  if (merged > 0) partition.dropped["exact duplicate"] += merged;
}

/// The neighbours for a normal: half as far again as they are where points are sparse. (The mean
/// distance to the k nearest of a disc's points is two thirds of that to the farthest.)
double normal_radius(const SpacingSampler& sampler, std::size_t neighbors) {
  constexpr double kFarthestPerMean = 1.5;
  constexpr double kMargin = 1.5;
  constexpr double kMostPerMedian = 16.0;
  const std::vector<double> means = neighbor_distances(sampler.sites(), neighbors);
  if (means.empty()) return 0.0;
  const double median = means[means.size() / 2];
  const double sparse = means[(means.size() - 1) * 99 / 100];
  return kFarthestPerMean * kMargin * std::min(sparse, kMostPerMedian * median);
}

/// Chunks as large as the radii that were found ask for, where those are not the ones expected.
Octree final_octree(const JobContext& context, const CountedCloud& cloud,
                    const Partition& partition) {
  const Job& job = context.job;
  const bool expected = !job.reconstruct.ball_radii.empty() || job.reconstruct.levels != 0;
  if (expected || partition.automatic_radii.empty()) return cloud.octree;
  const double points_per_area = 1.0 / (partition.spacing * partition.spacing);
  const MemoryPlan plan =
      plan_memory(job.partition.memory_bytes, cloud.points_used, context.threads(),
                  job.partition.chunk_points, cloud.schema,
                  worthwhile_points(partition.automatic_radii, points_per_area, cloud.points_used));
  if (plan.chunk_points <= cloud.memory.chunk_points) return cloud.octree;
  return coarsened(cloud.octree, plan.chunk_points);
}

}  // namespace

void measure(const InputContext& context, const CloudInput& input, const SpacingSampler& sampler,
             Partition& partition) {
  const RadiiChoice choice = sampler.choose(context.job.reconstruct.levels);
  partition.spacing = choice.spacing;
  partition.automatic_radii = choice.radii;
  partition.radii_reason = choice.reason;
  if (!input.are_scans) return;
  partition.layers = measure_layers(sampler.sites());
  if (!needs_preparation(context)) return;
  partition.normal_radius =
      normal_radius(sampler, static_cast<std::size_t>(context.job.normals.neighbors));
}

namespace {

/// First pass over the rows of one member.
CountedCloud count_share(const InputContext& context, const CloudInput& input, const Team& team) {
  CountedCloud cloud;
  const auto source = own_share(input.open(&cloud.notes), team);
  cloud.schema = source->schema();
  cloud.coordinate_system = source->coordinate_system();
  const bool has_view = view_offset(cloud.schema).has_value();
  stream_points(*source, {.threads = context.threads(), .stop = &context.stop}, {},
                [&](StreamBatch& batch) {
                  cloud.grid.add(batch.points.positions);
                  cloud.points_read += batch.points_read;
                  if (has_view) cloud.points_without_view += count_without_view(batch.points);
                  add_counts(cloud.dropped, batch.dropped);
                  context.progress.advance(batch.points_read);
                  context.progress.add_points(batch.points_read);
                });
  add_left_out(*source, cloud.points_read);
  add_counts(cloud.dropped, source->left_out());
  cloud.bytes_read = source->bytes_read();
  if (!has_view) cloud.points_without_view = cloud.grid.points();
  return cloud;
}

/// Every process is to have several chunks.
void plan_cut(const InputContext& context, CountedCloud& cloud, int processes) {
  cloud.points_used = cloud.grid.points();
  if (cloud.points_used == 0) {
    throw_bad_input(
        cloud.points_read == 0 ? "the cloud holds no points" : no_points_reason(cloud.dropped),
        {.file = context.files.front()});
  }
  cloud.grid.settle(root_cube(cloud.grid.bounds()).side);
  cloud.memory = plan_memory(context.job.partition.memory_bytes,
                             cloud.points_used / static_cast<std::uint64_t>(processes),
                             context.threads(), context.job.partition.chunk_points, cloud.schema,
                             worthwhile_chunk_points(cloud.grid, context.job.reconstruct));
  const std::uint64_t wanted = context.job.partition.chunk_points;
  if (cloud.memory.chunk_points < wanted) {
    cloud.notes.push_back("partition.chunk_points = " + std::to_string(wanted) +
                          " is more than the memory budget has room for; chunks get " +
                          std::to_string(cloud.memory.chunk_points) + " points");
  }
}

void cut(const InputContext& context, const CloudInput& input, CountedCloud& cloud) {
  cloud.octree = cut_octree(cloud.grid, root_cube(cloud.grid.bounds()), cloud.memory.chunk_points);
  split_dense_chunks(context, input, cloud);
}

}  // namespace

CountedCloud count_points(const InputContext& context, const CloudInput& input) {
  CountedCloud cloud = count_share(context, input, Team());
  plan_cut(context, cloud, 1);
  cut(context, input, cloud);
  return cloud;
}

std::optional<Partition> stored_partition(const ChunkStore& store, const std::string& stage) {
  const auto document = store.document(stage, kDocument);
  if (!document) return std::nullopt;
  return partition_from_json(*document);
}

void commit_partition(ChunkStore& store, const std::string& stage, const Partition& partition) {
  store.finish_commits();
  store.commit_document(stage, kDocument, partition_to_json(partition));
}

namespace {

Partition expected_partition(const ChunkStore& store, const std::string& stage) {
  return partition_from_json(store.expected_document(stage, kDocument));
}

/// First pass, by the whole team; `share` is what this member has read of it.
CountedCloud count_by_team(JobContext& context, const CloudInput& input, CutExchange& exchange,
                           std::uint64_t& share) {
  StageClock clock(context, input.prefix + "count", 0, "points");
  CountedCloud counted = count_share(context, input, context.team);
  share = counted.points_read;
  CountedCloud cloud = exchange.whole_cloud(std::move(counted));
  plan_cut(context, cloud, context.team.size());
  if (context.team.leads()) cut(context, input, cloud);
  cloud.octree = exchange.agreed_octree(cloud.octree);
  clock.facts().points = cloud.points_read;
  clock.facts().bytes_read = cloud.bytes_read;
  return cloud;
}

/// What the leader knows of the points once they are binned.
Partition describe_points(JobContext& context, const CloudInput& input, const CountedCloud& cloud,
                          const SpacingSampler& sampler) {
  Partition partition;
  {
    const StageClock clock(context, input.prefix + "measure", 0, "places");
    measure(context, input, sampler, partition);
  }
  partition.bounds = cloud.bounds;
  partition.memory_bytes = context.job.partition.memory_bytes;
  partition.schema = cloud.schema;
  partition.points_read = cloud.points_read;
  partition.dropped = cloud.dropped;
  partition.points_without_view = cloud.points_without_view;
  partition.coordinate_system = cloud.coordinate_system;
  partition.octree = final_octree(context, cloud, partition);
  return partition;
}

}  // namespace

Partition cut_and_sort(JobContext& context, const CloudInput& input) {
  CutExchange exchange(context, input.stage);
  std::uint64_t share = 0;
  CountedCloud cloud = count_by_team(context, input, exchange, share);
  for (const std::string& line : cloud.notes) context.note(line);
  SpacingSampler sampler(cloud.octree.root(), cloud.grid);
  cloud.bounds = cloud.grid.bounds();
  cloud.grid = CountGrid();
  if (context.team.leads()) check_room(context, input, cloud);
  Binner binner(cloud.octree, cloud.schema,
                {cloud.memory.bin_buffer_bytes, exchange.spill_directory(), &context.store.disk(),
                 exchange.spill_name()});
  bin_points(context, input, cloud, share, binner, sampler);
  if (input.are_scans) check_unchanged(context, input.stage);
  exchange.gather_samples(sampler);
  Partition partition;
  if (context.team.leads()) partition = describe_points(context, input, cloud, sampler);
  partition = exchange.agreed_partition(partition);
  auto published = exchange.all_bins(binner, cloud.schema);
  sort_chunks(context, input, cloud, published ? *published : static_cast<BinSource&>(binner),
              partition);
  // File systems over a network keep what is removed while somebody has it open.
  published.reset();
  exchange.end();
  number_points(context, input.stage, cloud, partition);
  return partition;
}

std::optional<Partition> begin_partition(JobContext& context, const std::string& stage,
                                         const std::string& key) {
  by_leader(context, [&] {
    begin_stage(context, stage, key);
    drop_what_does_not_fit(context, stage, key);
  });
  const bool is_there = context.team.leads() && stored_partition(context.store, stage).has_value();
  // The leader's word: a member may see the directory as it was a moment ago.
  if (context.team.leaders_word(is_there ? 1 : 0, context.stop) == 0) return std::nullopt;
  std::optional<Partition> stored = expected_partition(context.store, stage);
  context.team.meet(context.stop);  // what is there changes only when all have seen it
  return stored;
}

Partition partition_by_team(JobContext& context, const std::string& stage,
                            const std::function<Partition()>& make) {
  Partition partition = make();
  by_leader(context, [&] { commit_partition(context.store, stage, partition); });
  if (context.team.leads()) return partition;
  return expected_partition(context.store, stage);
}

Partition partition_points(JobContext& context) {
  if (std::optional<Partition> stored =
          begin_partition(context, kPointsStage, points_key(context))) {
    context.note("resuming: the points are partitioned already");
    if (context.team.leads()) discard_raw_stages(context.store);
    return std::move(*stored);
  }
  Partition partition = prepared_partition(context);
  if (context.team.leads()) discard_raw_stages(context.store);
  return partition;
}

}  // namespace orbweave
