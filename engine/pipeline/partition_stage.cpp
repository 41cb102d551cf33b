#include "engine/pipeline/partition_stage.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <limits>
#include <mutex>
#include <utility>

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
#include "partition/bin_records.h"
#include "partition/binning.h"
#include "partition/canonical_order.h"
#include "partition/count_grid.h"
#include "partition/memory_plan.h"

namespace orbweave {
namespace {

constexpr const char* kDocument = "partition";
/// How the points are cut, while they are being sorted.
constexpr const char* kCutDocument = "cut";

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

/// A member that is killed while it bins repeats no more than such a part of its share, or what
/// fits the buffers.
constexpr std::uint64_t kPartsOfShare = 16;

/// Second pass: every point of the member's share that an earlier run has not binned goes to the
/// bin of its chunk. Returns the points of the share.
std::uint64_t bin_points(JobContext& context, const CloudInput& input, const CountedCloud& cloud,
                         Binner& binner, SpacingSampler& sampler, BinLog& log,
                         std::uint64_t points_before) {
  const auto source =
      own_share(input.open(nullptr), context.team, points_before, cloud.rows_left_out == 0);
  StageClock clock(context, input.prefix + "bin", cloud.own_share, "points");
  context.progress.advance(points_before);
  std::uint64_t points_read = points_before, points_kept = points_before, bytes_kept = 0;
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
        if (binner.spilled_bytes() == bytes_kept ||
            points_read - points_kept < cloud.own_share / kPartsOfShare)
          return;
        log.append(points_read, binner.write_out(), sampler, false);
        points_kept = points_read;
        bytes_kept = binner.spilled_bytes();
      });
  clock.facts().points = points_read - points_before;
  clock.facts().bytes_read = source->bytes_total();
  clock.facts().bytes_written = binner.spilled_bytes();
  return points_read;
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

/// Gives the room of bins back when their points are sorted and durable, and lets nobody sort on
/// while too many are not.
class BinRoom {
 public:
  BinRoom(ChunkStore& store, BinSource& bins, std::uint64_t most_waiting_bytes)
      : store_(store), bins_(bins), most_waiting_bytes_(most_waiting_bytes) {}

  /// The points of bins [first, last) were committed. Thread-safe.
  void committed(ChunkId first, ChunkId last, std::uint64_t bytes) {
    std::uint64_t awaited = 0;
    {
      const std::scoped_lock lock(mutex_);
      waiting_.push_back({store_.commits_begun(), first, last, bytes});
      waiting_bytes_ += bytes;
      std::uint64_t beyond = waiting_bytes_ - std::min(waiting_bytes_, most_waiting_bytes_);
      for (auto bin = waiting_.begin(); beyond > 0 && bin != waiting_.end(); ++bin) {
        awaited = bin->commits;
        beyond -= std::min(beyond, bin->bytes);
      }
    }
    if (awaited > 0) store_.await_durable(awaited);
    give_back();
  }

 private:
  struct Waiting {
    std::uint64_t commits = 0;  ///< durable when so many are
    ChunkId first = 0, last = 0;
    std::uint64_t bytes = 0;
  };

  void give_back() {
    std::vector<Waiting> durable;
    {
      const std::scoped_lock lock(mutex_);
      const std::uint64_t commits = store_.commits_durable();
      for (; !waiting_.empty() && waiting_.front().commits <= commits; waiting_.pop_front()) {
        waiting_bytes_ -= waiting_.front().bytes;
        durable.push_back(waiting_.front());
      }
    }
    for (const Waiting& bins : durable)
      for (ChunkId bin = bins.first; bin < bins.last; ++bin) bins_.give_back(bin);
  }

  ChunkStore& store_;
  BinSource& bins_;
  const std::uint64_t most_waiting_bytes_;
  std::mutex mutex_;
  std::deque<Waiting> waiting_;
  std::uint64_t waiting_bytes_ = 0;
};

/// Sorts every chunk canonically and commits it; `room_bytes`: what the bins may take beside what
/// they became.
void sort_chunks(JobContext& context, const CloudInput& input, const CountedCloud& cloud,
                 BinSource& bins, const Partition& partition, std::uint64_t room_bytes) {
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
  BinRoom room(context.store, bins, room_bytes);
  share_chunks(
      context, clock, input.stage, std::move(tasks), cloud.memory.chunks_in_flight_bytes / 2,
      [&](ChunkId chunk) {
        commit_points(context.store, chunk,
                      take_sorted(bins, cloud.octree, chunks[chunk], most).points, input.stage);
        const auto [first, last] = bins_in(cloud.octree, chunks[chunk]);
        room.committed(first, last, chunks[chunk].points * RecordLayout(cloud.schema).bytes);
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

}  // namespace

Octree final_octree(const InputContext& context, const CountedCloud& cloud,
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
  for (const auto& [reason, count] : source->left_out()) cloud.rows_left_out += count;
  cloud.points_read += cloud.rows_left_out;
  cloud.own_share = cloud.points_read;
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

/// First pass, by the whole team.
CountedCloud count_by_team(JobContext& context, const CloudInput& input, CutExchange& exchange) {
  StageClock clock(context, input.prefix + "count", 0, "points");
  CountedCloud cloud = exchange.whole_cloud(count_share(context, input, context.team));
  plan_cut(context, cloud, context.team.size());
  if (context.team.leads()) cut(context, input, cloud);
  cloud.bounds = cloud.grid.bounds();
  clock.facts().points = cloud.points_read;
  clock.facts().bytes_read = cloud.bytes_read;
  return cloud;
}

/// Where distances are measured; the count is over then. It is kept where that spares more than it
/// costs: bins that fit in memory are quickly made again.
SpacingSampler sampler_of(JobContext& context, CutExchange& exchange, CountedCloud& cloud) {
  SpacingSampler sampler(root_cube(cloud.bounds), cloud.grid);
  cloud.grid = CountGrid();
  if (context.team.size() > 1 || bins_will_spill(cloud)) exchange.keep_count(cloud, sampler);
  return sampler;
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

namespace {

/// Second pass, and what is measured on the way. `bins` are all members' afterwards.
Partition bin_by_team(JobContext& context, const CloudInput& input, CutExchange& exchange,
                      CountedCloud& cloud, SpacingSampler& sampler,
                      std::unique_ptr<BinSource>& bins) {
  BinLog log = exchange.own_log();
  BinnedSoFar before;
  if (exchange.found() == CutExchange::Found::kCounted) before = log.load(sampler);
  Binner::Options options{cloud.memory.bin_buffer_bytes, log.spill_file(), &context.store.disk()};
  options.before_spilling = [&] { exchange.keep_count(cloud, sampler); };
  options.kept_bytes = before.file_bytes;
  auto own = std::make_unique<Binner>(cloud.octree, cloud.schema, std::move(options));
  std::uint64_t points_read = before.points_read;
  if (!before.complete)
    points_read = bin_points(context, input, cloud, *own, sampler, log, before.points_read);
  if (input.are_scans) check_unchanged(context, input.stage);
  if (exchange.keeps() && !before.complete) log.append(points_read, own->publish(), sampler, true);
  exchange.await_bins(cloud, points_read);
  exchange.gather_samples(sampler);
  Partition partition;
  if (context.team.leads()) partition = describe_points(context, input, cloud, sampler);
  partition = exchange.agreed_partition(partition);
  if (exchange.keeps()) {
    own.reset();
    bins = exchange.all_bins(cloud.schema);
  } else {
    bins = std::move(own);
  }
  return partition;
}

}  // namespace

Partition cut_and_sort(JobContext& context, const CloudInput& input) {
  CutExchange exchange(context, input);
  const bool is_counted = exchange.found() != CutExchange::Found::kNothing;
  const bool is_binned = exchange.found() == CutExchange::Found::kBinned;
  CountedCloud cloud = is_counted ? exchange.counted() : count_by_team(context, input, exchange);
  for (const std::string& line : cloud.notes) context.note(line);
  if (is_counted)
    context.note(std::string("resuming: the points are counted ") +
                 (is_binned ? "and binned " : "") + "already");
  std::unique_ptr<BinSource> bins;
  Partition partition;
  std::uint64_t room_bytes = 0;
  if (is_binned) {
    room_bytes = check_room(context, input, cloud);
    partition = exchange.measured();
    bins = exchange.all_bins(cloud.schema);
  } else {
    SpacingSampler sampler = is_counted ? exchange.sampler() : sampler_of(context, exchange, cloud);
    room_bytes = check_room(context, input, cloud);
    partition = bin_by_team(context, input, exchange, cloud, sampler, bins);
  }
  if (!exchange.keeps()) room_bytes = std::numeric_limits<std::uint64_t>::max();
  sort_chunks(context, input, cloud, *bins, partition, room_bytes);
  // File systems over a network keep what is removed while somebody has it open.
  bins.reset();
  context.team.meet(context.stop);
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
  if (context.team.leads()) context.store.discard_stage(cut_stage_of(stage));
  std::optional<Partition> stored = expected_partition(context.store, stage);
  context.team.meet(context.stop);  // what is there changes only when all have seen it
  return stored;
}

Partition partition_by_team(JobContext& context, const std::string& stage,
                            const std::function<Partition()>& make) {
  Partition partition = make();
  by_leader(context, [&] {
    commit_partition(context.store, stage, partition);
    context.store.discard_stage(cut_stage_of(stage));
  });
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
