#include "engine/pipeline/points/cut_stage.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <memory>
#include <mutex>
#include <utility>

#include "engine/pipeline/budget/disk_plan.h"
#include "engine/pipeline/budget/time_forecast.h"
#include "engine/pipeline/points/cloud_measure.h"
#include "engine/pipeline/points/count_stage.h"
#include "engine/pipeline/points/cut_exchange.h"
#include "engine/pipeline/points/dense_chunks.h"
#include "engine/pipeline/points/own_share.h"
#include "engine/pipeline/stage/stage_begin.h"
#include "engine/spacing/automatic_radii.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/report/reasons.h"
#include "io/store/chunk_points.h"
#include "io/system/owned_files.h"
#include "partition/bin_records.h"
#include "partition/binning.h"

namespace orbweave {
namespace {

/// How the points are cut, while they are being sorted.
constexpr const char* kCutDocument = "cut";

/// A member that is killed while it bins repeats no more than such a part of its share, or what
/// fits the buffers.
constexpr std::uint64_t kPartsOfShare = 16;

/// Second pass: every point of the member's share that an earlier run has not binned goes to the
/// bin of its chunk, and to the store where that keeps bins. Returns the points of the share.
std::uint64_t bin_points(StageRunner& runner, const CloudInput& input, const CutExchange& cut,
                         CountedCloud& cloud, Binner& binner, SpacingSampler& sampler, BinLog& log,
                         std::uint64_t points_before) {
  const bool are_here = cloud.remembered.are_all() && points_before == 0;
  const auto source = are_here ? cloud.remembered.source(cloud.schema)
                               : own_share(input.open(nullptr), runner.communicator, points_before,
                                           cloud.rows_left_out == 0);
  StageClock clock(runner, input.stages.bin, cloud.own_share, "points");
  runner.progress.advance(points_before);
  std::uint64_t points_read = points_before, points_kept = points_before, bytes_kept = 0;
  stream_points(
      *source, {.threads = runner.threads(), .stop = &runner.stop, .filter = &cloud.filter},
      [&](StreamBatch& batch) {
        batch.chunks.resize(batch.points.size());
        for (std::size_t i = 0; i < batch.points.size(); ++i) {
          batch.chunks[i] = cloud.octree.chunk_of(batch.points.positions[i]);
        }
      },
      [&](StreamBatch& batch) {
        binner.add(batch.points, batch.chunks);
        sampler.add(batch.points.positions, cloud.extents.index_of(batch.scan));
        points_read += batch.points_read;
        runner.progress.advance(batch.points_read);
        runner.progress.add_points(batch.points_read);
        if (binner.spilled_bytes() == bytes_kept ||
            points_read - points_kept < cloud.own_share / kPartsOfShare)
          return;
        log.append(points_read, binner.write_out(), sampler, false);
        points_kept = points_read;
        bytes_kept = binner.spilled_bytes();
      });
  if (are_here) points_read = cloud.own_share - cloud.rows_left_out;  // the others were dropped
  if (input.are_scans) check_unchanged(runner, input.stages.points());
  if (cut.keeps) log.append(points_read, binner.publish(), sampler, true);
  clock.facts().points = points_read - points_before;
  // The shares are the whole of the scans; the store counts what cleaned points are read from.
  if (input.are_scans && runner.communicator.is_root())
    clock.facts().bytes_read = source->bytes_total();
  clock.facts().bytes_written = binner.spilled_bytes();
  return points_read;
}

/// Chunks that an earlier run sorted are taken where it had cut the points in the same way.
void keep_what_is_sorted(StageRunner& runner, const std::string& stage,
                         const Partition& partition) {
  Partition cut;
  cut.schema = partition.schema;
  cut.octree = partition.octree;
  const std::string text = partition_to_json(cut);
  if (runner.store.document(stage, kCutDocument) == text) return;
  // Under the same key: chunks of another cut are not to be taken for these, ever.
  runner.store.begin_stage_anew(stage, stored_key(runner.store, stage));
  runner.store.commit_document(stage, kCutDocument, text);
}

/// Gives the room of bins back when their points are sorted and durable, and holds sorting
/// back while too many are not.
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
void sort_chunks(StageRunner& runner, const CloudInput& input, const CountedCloud& cloud,
                 BinSource& bins, const Partition& partition, std::uint64_t room_bytes) {
  const auto& chunks = partition.octree.chunks();
  const std::string stage = input.stages.points();
  by_root(runner, [&] { keep_what_is_sorted(runner, stage, partition); });
  StageClock clock(runner, input.stages.sort, chunks.size(), "chunks");
  std::vector<ChunkWork> tasks;
  const std::uint64_t most = most_sorted_points(cloud.memory, cloud.schema);
  for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk) {
    const std::uint64_t points = std::min(chunks[chunk].points, 2 * most);
    tasks.push_back({chunk, points * MemoryCosts::sort_bytes(cloud.schema), chunks[chunk].points,
                     chunks[chunk].points});
  }
  BinRoom room(runner.store, bins, room_bytes);
  share_chunks(
      runner, clock, stage, std::move(tasks), cloud.memory.chunks_in_flight_bytes / 2,
      [&](ChunkId chunk) {
        commit_points(runner.store, chunk,
                      take_sorted(bins, cloud.octree, chunks[chunk], most, &runner.stop).points,
                      stage);
        const auto [first, last] = bins_in(cloud.octree, chunks[chunk]);
        room.committed(first, last, chunks[chunk].points * RecordLayout(cloud.schema).bytes);
      });
  clock.facts().points = cloud.points_used;
  clock.facts().bytes_read = bins.bytes_read();
}

/// Numbers the points that are left once duplicates are merged.
void number_points(StageRunner& runner, const std::string& stage, const CountedCloud& cloud,
                   Partition& partition) {
  partition.first_vertex.assign(1, 0);
  for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk) {
    partition.first_vertex.push_back(partition.first_vertex.back() +
                                     stored_points(runner.store, chunk, stage));
  }
  const std::uint64_t merged = cloud.points_used - partition.points();
  if (merged > 0) partition.dropped[text_of(DropReason::kDuplicate)] += merged;
}

/// A place that the count grid cannot cut further is measured as a whole.
void require_memory_for_sample(const ResolvedJob& job, const CountedCloud& cloud,
                               const SpacingSampler& sampler) {
  const std::uint64_t least = MemoryCosts::kBaseBytes +
                              MemoryCosts::stream_bytes(cloud.schema, job.threads()) +
                              sampler.memory_bytes();
  const std::uint64_t budget = job.partition.memory_bytes;
  if (budget >= least) return;
  throw_resource("the memory budget is too small to measure the distances between the points",
                 {.place = setting_name(job, "partition.memory"),
                  .found = std::to_string(budget >> 20) + " MiB",
                  .expected = "at least " + std::to_string((least >> 20) + 1) +
                              " MiB, as many points lie in a tiny part of the cloud's extent",
                  .advice = "Leave out what lies far away"});
}

/// Where distances are measured; the count is over then. It is kept where that spares more than it
/// costs: bins that fit in memory are quickly made again.
SpacingSampler sampler_of(CutExchange& cut, CountedCloud& cloud, StageRunner& runner) {
  SpacingSampler sampler(root_cube(cloud.bounds), cloud.grid);
  cloud.grid = CountGrid();
  if (cloud.extents.all().size() > 1) sampler.collect_scans();
  require_memory_for_sample(runner.job, cloud, sampler);
  if (runner.communicator.size() > 1 || bins_will_spill(size_of(cloud)))
    keep_count(cut, cloud, sampler, runner);
  return sampler;
}

/// What the leader knows of the points once they are binned.
Partition describe_points(const CloudInput& input, const CountedCloud& cloud,
                          SpacingSampler& sampler, StageRunner& runner) {
  const StageClock clock(runner, input.stages.measure, 0, "places");
  const std::vector<std::string> doubts = objections_to_surfaces(
      runner.job, cloud.extents, sampler, cloud.meters_per_unit, runner.stop);
  Partition partition = measure(input, sampler, runner);
  for (const std::string& doubt : doubts) partition.said.push_back({doubt, doubt, true});
  runner.progress.advance(sampler.sites().size());
  partition.bounds = cloud.bounds;
  partition.memory_bytes = runner.job.partition.memory_bytes;
  partition.schema = cloud.schema;
  partition.points_read = cloud.points_read;
  partition.dropped = cloud.dropped;
  partition.points_without_view = cloud.points_without_view;
  partition.coordinate_system = cloud.coordinate_system;
  partition.meters_per_unit = cloud.meters_per_unit;
  partition.has_wide_colors = cloud.has_wide_colors;
  partition.octree =
      is_cut_again(input) ? cloud.octree : final_octree(runner.job, cloud, partition);
  return partition;
}

/// Points in bins, and what was measured on the way.
struct BinnedCloud {
  Partition partition;
  std::unique_ptr<BinSource> bins;  ///< all members'
};

/// Second pass.
BinnedCloud bin_by_team(const CloudInput& input, CutExchange& cut, CountedCloud& cloud,
                        SpacingSampler& sampler, StageRunner& runner) {
  BinLog log = own_log(cut, runner);
  BinnedSoFar before;
  if (cut.found == CutExchange::Found::kCounted) before = log.load(sampler);
  Binner::Options options{cloud.memory.bin_buffer_bytes, log.spill_file(), &runner.store.disk()};
  options.before_spilling = [&] {
    keep_count(cut, cloud, sampler, runner);
    if (!runner.store.claim(log.spill_file())) throw_stranger(log.spill_file());
  };
  options.kept_bytes = before.file_bytes;
  auto own = std::make_unique<Binner>(cloud.octree, cloud.schema, std::move(options));
  std::uint64_t points_read = before.points_read;
  if (before.complete) {
    if (input.are_scans) check_unchanged(runner, input.stages.points());
  } else {
    points_read = bin_points(runner, input, cut, cloud, *own, sampler, log, before.points_read);
  }
  await_bins(cut, cloud, points_read, runner);
  gather_samples(cut, runner, sampler);
  BinnedCloud binned;
  if (runner.communicator.is_root())
    binned.partition = describe_points(input, cloud, sampler, runner);
  binned.partition = agreed_partition(cut, binned.partition, runner);
  if (!cut.keeps) {
    binned.bins = std::move(own);
    return binned;
  }
  own.reset();
  binned.bins = all_bins(cut, runner, cloud.schema);
  return binned;
}

/// What an earlier run cut already.
void note_resumed(const CutExchange& cut, StageRunner& runner) {
  if (cut.found == CutExchange::Found::kNothing) return;
  const bool is_binned = cut.found == CutExchange::Found::kBinned;
  runner.note(std::string("resuming: the points are counted ") + (is_binned ? "and binned " : "") +
              "already");
}

}  // namespace

CutPoints cut_and_sort(const CloudInput& input, StageRunner& runner) {
  CutExchange cut = begin_cut(input, runner);
  const bool is_counted = cut.found != CutExchange::Found::kNothing;
  CountedCloud cloud = is_counted ? stored_count(cut, runner) : count_by_team(input, cut, runner);
  for (const std::string& line : cloud.notes) runner.say_of_points({line, line});
  for (const std::string& line : cloud.doubts) runner.say_of_points({line, line, true});
  note_resumed(cut, runner);
  JobSize size;
  size.points = size.kept_points = cloud.points_used;
  size.processes = runner.communicator.size();
  runner.progress.expect(expected_stages(runner.job, size));
  BinnedCloud binned;
  RoomPlan room;
  if (cut.found == CutExchange::Found::kBinned) {
    room = check_room(runner, input.stages, input.are_scans, size_of(cloud));
    binned = {measured_partition(cut, runner), all_bins(cut, runner, cloud.schema)};
  } else {
    SpacingSampler sampler =
        is_counted ? stored_sampler(cut, runner) : sampler_of(cut, cloud, runner);
    room = check_room(runner, input.stages, input.are_scans, size_of(cloud));
    binned = bin_by_team(input, cut, cloud, sampler, runner);
  }
  for (const SaidLine& line : binned.partition.said) runner.say_of_points(line);
  if (!cut.keeps) room.bin_bytes = std::numeric_limits<std::uint64_t>::max();
  sort_chunks(runner, input, cloud, *binned.bins, binned.partition, room.bin_bytes);
  // File systems over a network keep what is removed while a process has it open.
  binned.bins.reset();
  runner.communicator.barrier(runner.stop);
  number_points(runner, input.stages.points(), cloud, binned.partition);
  return {std::move(binned.partition), room.predicted_disk_bytes};
}

std::optional<Partition> begin_partition(StageRunner& runner, const CutStages& stages,
                                         const std::string& key) {
  const std::string stage = stages.points();
  by_root(runner, [&] {
    if (!holds_points(runner.store, stage, key)) begin_stage(runner, stage, key);
    drop_what_does_not_fit(runner, stage, key);
  });
  const bool is_there =
      runner.communicator.is_root() && stored_partition(runner.store, stage).has_value();
  // The root decides: another process may see the directory as it was a moment ago.
  if (runner.communicator.broadcast(is_there ? 1 : 0, runner.stop) == 0) return std::nullopt;
  if (runner.communicator.is_root()) runner.store.discard_stage(stages.cut());
  std::optional<Partition> stored = expected_partition(runner.store, stage);
  runner.communicator.barrier(runner.stop);  // what is there changes only when all have seen it
  return stored;
}

CutPoints partition_by_team(StageRunner& runner, const CutStages& stages,
                            const std::function<CutPoints()>& make) {
  CutPoints points = make();
  by_root(runner, [&] {
    points.partition.said = runner.of_points;
    commit_partition(runner.store, stages.points(), points.partition);
    runner.store.discard_stage(stages.cut());
  });
  if (!runner.communicator.is_root())
    points.partition = expected_partition(runner.store, stages.points());
  return points;
}

}  // namespace orbweave
