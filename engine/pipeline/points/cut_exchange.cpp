#include "engine/pipeline/points/cut_exchange.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>
#include <vector>

#include "engine/pipeline/stage/stage_begin.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "io/error.h"
#include "io/text/json_dump.h"

namespace orbweave {
namespace {

using Json = nlohmann::json;

/// How the points are cut, once they are counted.
constexpr const char* kCounted = "counted";
/// What is known of them once they are binned.
constexpr const char* kMeasured = "measured";
/// What is found where a log that was complete no longer is.
constexpr const char* kIncomplete = "damage to the file, or to the log of what lies in it";

// The numbers of what lies in the stage: the counts of members, their sum, the sites of the
// sampler, and then the parts of the members' logs.
ChunkId counts_of(int rank) { return static_cast<ChunkId>(rank); }
ChunkId sites_of(int members) { return static_cast<ChunkId>(members + 1); }
ChunkId first_of_logs(int members) { return static_cast<ChunkId>(members + 2); }

std::string facts_text(const CountedCloud& cloud) {
  return document_text({{"points_read", cloud.points_read},
                        {"bytes_read", cloud.bytes_read},
                        {"rows_left_out", cloud.rows_left_out},
                        {"dropped", cloud.dropped},
                        {"points_without_view", cloud.points_without_view},
                        {"has_wide_colors", cloud.has_wide_colors},
                        {"at_scan_origins", cloud.at_scan_origins},
                        {"extents", extents_text(cloud.extents)}});
}

void add_facts(const StoredResult& stored, CountedCloud& cloud) {
  const auto text = stored.read_all<char>("facts");
  const Json facts = document_from({text.data(), text.size()});
  cloud.points_read += facts.at("points_read").get<std::uint64_t>();
  // A place in the scans: the last share ends where the scans end.
  cloud.bytes_read = std::max(cloud.bytes_read, facts.at("bytes_read").get<std::uint64_t>());
  cloud.rows_left_out += facts.at("rows_left_out").get<std::uint64_t>();
  cloud.points_without_view += facts.at("points_without_view").get<std::uint64_t>();
  if (facts.at("has_wide_colors").get<bool>()) cloud.has_wide_colors = true;
  add_origin_counts(cloud.at_scan_origins,
                    facts.at("at_scan_origins").get<std::vector<std::uint64_t>>());
  add_extents(facts.at("extents").get<std::string>(), cloud.extents);
  const auto dropped = facts.at("dropped").get<DroppedPoints>();
  for (const auto& [reason, count] : dropped) cloud.dropped[reason] += count;
}

void commit_counts(ChunkStore& store, const std::string& stage, ChunkId number,
                   const CountedCloud& cloud) {
  const CountGrid::Part part = cloud.grid.part();
  const std::string facts = facts_text(cloud);
  // An empty box has infinite corners, which are stored like any others.
  const std::array<ArrayView, 5> arrays = {
      ArrayView{"cell", ScalarType::kFloat64, 1, 1, &part.cell},
      ArrayView{"bounds", ScalarType::kFloat64, 6, 1, &part.bounds},
      ArrayView{"corners", ScalarType::kFloat64, 3, part.corners.size(), part.corners.data()},
      ArrayView{"counts", ScalarType::kUint64, 1, part.counts.size(), part.counts.data()},
      ArrayView{"facts", ScalarType::kUint8, 1, facts.size(), facts.data()}};
  store.commit(stage, number, arrays);
}

CountGrid::Part load_counts(const ChunkStore& store, const std::string& stage, ChunkId number,
                            CountedCloud& cloud) {
  const auto stored = store.open(stage, number);
  CountGrid::Part part;
  stored->read("cell", 0, 1, &part.cell);
  stored->read("bounds", 0, 1, &part.bounds);
  part.corners = stored->read_all<Vec3>("corners");
  part.counts = stored->read_all<std::uint64_t>("counts");
  add_facts(*stored, cloud);
  return part;
}

/// The boxes of a sampler's sites, without their points.
void commit_sites(ChunkStore& store, const std::string& stage, ChunkId number,
                  std::span<const SpacingSite> sites) {
  std::vector<Box> boxes;
  for (const SpacingSite& site : sites) boxes.insert(boxes.end(), {site.core, site.box});
  const std::array<ArrayView, 1> arrays = {
      ArrayView{"sites", ScalarType::kFloat64, 12, sites.size(), boxes.data()}};
  store.commit(stage, number, arrays);
}

std::vector<double> numbers_of(Vec3 v) { return {v.x, v.y, v.z}; }
Vec3 vector_of(const Json& numbers) { return {numbers.at(0), numbers.at(1), numbers.at(2)}; }

Json to_json(const std::vector<Vec3>& points) {
  Json list = Json::array();
  for (const Vec3& p : points) list.push_back(numbers_of(p));
  return list;
}
std::vector<Vec3> vectors_of(const Json& list) {
  std::vector<Vec3> points;
  for (const Json& numbers : list) points.push_back(vector_of(numbers));
  return points;
}

Json to_json(const PointFilter& filter) {
  return {{"min", numbers_of(filter.within.min)},
          {"max", numbers_of(filter.within.max)},
          {"no_data_values", filter.takes_no_data_values},
          {"scan_origins", to_json(filter.scan_origins)},
          {"missing_returns", to_json(filter.missing_returns)}};
}

PointFilter filter_from_json(const Json& json) {
  PointFilter filter;
  filter.within = {vector_of(json.at("min")), vector_of(json.at("max"))};
  filter.takes_no_data_values = json.at("no_data_values");
  filter.scan_origins = vectors_of(json.at("scan_origins"));
  filter.missing_returns = vectors_of(json.at("missing_returns"));
  return filter;
}

std::string counted_text(const CountedCloud& cloud, std::uint64_t memory_bytes, int members) {
  Partition cut;
  cut.schema = cloud.schema;
  cut.bounds = cloud.bounds;
  cut.octree = cloud.octree;
  cut.memory_bytes = memory_bytes;
  cut.points_read = cloud.points_read;
  cut.dropped = cloud.dropped;
  cut.points_without_view = cloud.points_without_view;
  cut.coordinate_system = cloud.coordinate_system;
  cut.meters_per_unit = cloud.meters_per_unit;
  cut.has_wide_colors = cloud.has_wide_colors;
  for (const std::string& line : cloud.notes) cut.said.push_back({line, line});
  for (const std::string& line : cloud.doubts) cut.said.push_back({line, line, true});
  return document_text({{"members", members},
                        {"chunk_points", cloud.memory.chunk_points},
                        {"rows_left_out", cloud.rows_left_out},
                        {"bytes_read", cloud.bytes_read},
                        {"filter", to_json(cloud.filter)},
                        {"extents", extents_text(cloud.extents)},
                        {"cut", partition_to_json(cut)}});
}

static_assert(sizeof(Box) == 6 * sizeof(double), "stored as rows of 64-bit words");

using Found = CutExchange::Found;

BinLog log_of(const CutExchange& cut, ChunkStore& store, int rank) {
  return {store, cut.stage, rank, cut.members, first_of_logs(cut.members)};
}

bool bins_are_whole(const CutExchange& cut, ChunkStore& store) {
  for (int rank = 0; rank < cut.members; ++rank)
    if (!log_of(cut, store, rank).load_extents().complete) return false;
  return true;
}

void commit_count(const CutExchange& cut, const CountedCloud& cloud, const SpacingSampler& sampler,
                  StageRunner& runner) {
  runner.store.begin_stage(cut.stage, cut.key);
  commit_sites(runner.store, cut.stage, sites_of(cut.members), sampler.sites());
  runner.store.finish_commits();
  runner.store.commit_document(cut.stage, kCounted,
                               counted_text(cloud, runner.job.partition.memory_bytes, cut.members));
}

/// The count of an earlier run whose bins cannot be used. Where that run had another number of
/// members, the shares are others now, and only the count stays.
Found take_count(CutExchange& cut, int members_before, StageRunner& runner) {
  try {
    cut.members = members_before;
    const SpacingSampler sites = stored_sampler(cut, runner);
    const CountedCloud cloud = stored_count(cut, runner);
    cut.members = runner.communicator.size();
    if (cut.members == members_before) return Found::kCounted;
    runner.store.discard_stage(cut.stage);
    commit_count(cut, cloud, sites, runner);
    return Found::kCounted;
  } catch (const CorruptResult&) {
    cut.members = runner.communicator.size();
    return Found::kNothing;
  }
}

/// How much of what lies there can be used by this run.
Found examine(CutExchange& cut, StageRunner& runner) {
  const auto document = runner.store.document(cut.stage, kCounted);
  if (!document || !runner.store.has_key(cut.stage, cut.key)) return Found::kNothing;
  const Json facts = document_from(*document);
  const int members_before = facts.at("members");
  const Partition before = partition_from_json(facts.at("cut").get<std::string>());
  std::uint64_t largest = 0;
  for (const Chunk& chunk : before.octree.chunks()) largest = std::max(largest, chunk.points);
  const std::string reason = reason_not_to_fit(runner.job, before.memory_bytes, largest,
                                               before.octree.points(), before.schema);
  if (!reason.empty()) {
    runner.note(reason + ": they are cut again");
    return Found::kNothing;
  }
  if (runner.store.document(cut.stage, kMeasured)) {
    cut.members = members_before;
    if (bins_are_whole(cut, runner.store)) return Found::kBinned;
    runner.note("points that were binned are damaged or gone: they are read again");
  }
  return take_count(cut, members_before, runner);
}

/// Adds what another member has counted.
void merge_counts(const ChunkStore& store, const std::string& stage, int other,
                  CountedCloud& cloud) {
  std::array<CountGrid::Part, 2> parts = {cloud.grid.part(), {}};
  cloud.grid = CountGrid();
  parts[1] = load_counts(store, stage, counts_of(other), cloud);
  cloud.grid = CountGrid::of_parts(parts);
}

/// Merges the counts of all members by a binary tree: in step k, member r takes those of member
/// r + 2^k. Every other member stores its counts once, in the step of its lowest bit; the root ends
/// with the whole. The grid does not depend on the order in which shares are merged.
void reduce_counts(const CutExchange& cut, StageRunner& runner, CountedCloud& cloud) {
  const int rank = runner.communicator.rank();
  const int size = runner.communicator.size();
  for (int distance = 1; distance < size; distance *= 2) {
    if (rank % (2 * distance) == distance) {
      commit_counts(runner.store, cut.stage, counts_of(rank), cloud);
      runner.store.finish_commits();
    }
    runner.communicator.barrier(runner.stop);
    const bool takes = rank % (2 * distance) == 0 && size - rank > distance;
    if (takes) merge_counts(runner.store, cut.stage, rank + distance, cloud);
  }
}

/// The points that all members have binned. Throws CorruptResult where a log is not complete.
std::uint64_t points_binned(const CutExchange& cut, const StageRunner& runner) {
  std::uint64_t points = 0;
  for (int rank = 0; rank < cut.members; ++rank) {
    const BinLog log = log_of(cut, runner.store, rank);
    const BinnedSoFar binned = log.load_extents();
    if (!binned.complete) throw CorruptResult(log.spill_file(), kIncomplete);
    points += binned.points_read;
  }
  return points;
}

}  // namespace

CutExchange begin_cut(const CloudInput& input, StageRunner& runner) {
  CutExchange cut;
  cut.stage = input.stages.cut();
  cut.members = runner.communicator.size();
  if (runner.communicator.is_root()) {
    cut.key = stored_key(runner.store, input.stages.points()) + input.order +
              key_line("layout of bins", "4");
    cut.found = examine(cut, runner);
    if (cut.found == Found::kNothing) runner.store.discard_stage(cut.stage);
    if (runner.communicator.size() > 1) runner.store.begin_stage(cut.stage, cut.key);
  }
  const auto word = static_cast<std::uint64_t>(cut.found);
  cut.found = static_cast<Found>(runner.communicator.broadcast(word, runner.stop));
  cut.keeps = cut.found != Found::kNothing;
  if (!cut.keeps) return cut;
  cut.members = document_from(runner.store.expected_document(cut.stage, kCounted)).at("members");
  runner.communicator.barrier(runner.stop);  // what is there changes only when all have seen it
  return cut;
}

CountedCloud stored_count(const CutExchange& cut, const StageRunner& runner) {
  const Json facts = document_from(runner.store.expected_document(cut.stage, kCounted));
  Partition before = partition_from_json(facts.at("cut").get<std::string>());
  CountedCloud cloud;
  cloud.schema = std::move(before.schema);
  cloud.points_read = before.points_read;
  cloud.points_used = before.octree.points();
  cloud.bytes_read = facts.at("bytes_read");
  cloud.rows_left_out = facts.at("rows_left_out");
  cloud.dropped = std::move(before.dropped);
  cloud.points_without_view = before.points_without_view;
  cloud.coordinate_system = std::move(before.coordinate_system);
  cloud.meters_per_unit = before.meters_per_unit;
  cloud.has_wide_colors = before.has_wide_colors;
  for (SaidLine& line : before.said)
    (line.is_warning ? cloud.doubts : cloud.notes).push_back(std::move(line.shown));
  cloud.bounds = before.bounds;
  cloud.octree = std::move(before.octree);
  const auto size = static_cast<std::uint64_t>(runner.communicator.size());
  cloud.own_share = cloud.points_read / size;
  cloud.memory = runner.job.memory_plan(cloud.points_used / size, cloud.schema);
  cloud.memory.chunk_points = facts.at("chunk_points");
  cloud.filter = filter_from_json(facts.at("filter"));
  add_extents(facts.at("extents").get<std::string>(), cloud.extents);
  return cloud;
}

SpacingSampler stored_sampler(const CutExchange& cut, const StageRunner& runner) {
  const auto boxes = runner.store.open(cut.stage, sites_of(cut.members))->read_all<Box>("sites");
  std::vector<SpacingSite> sites;
  for (std::size_t i = 0; i + 1 < boxes.size(); i += 2)
    sites.push_back({boxes[i], boxes[i + 1], {}});
  const CountedCloud cloud = stored_count(cut, runner);
  SpacingSampler sampler(std::move(sites), cloud.points_used);
  if (cloud.extents.all().size() > 1) sampler.collect_scans();
  return sampler;
}

CountedCloud whole_cloud(CountedCloud share, const CutExchange& cut, StageRunner& runner) {
  if (runner.communicator.size() == 1) return share;
  reduce_counts(cut, runner, share);
  const ChunkId sum = counts_of(runner.communicator.size());
  by_root(runner, [&] {
    commit_counts(runner.store, cut.stage, sum, share);
    runner.store.finish_commits();
  });
  CountedCloud whole;
  whole.schema = std::move(share.schema);
  whole.coordinate_system = std::move(share.coordinate_system);
  whole.meters_per_unit = share.meters_per_unit;
  whole.notes = std::move(share.notes);
  whole.own_share = share.own_share;
  whole.filter = std::move(share.filter);
  const CountGrid::Part part = load_counts(runner.store, cut.stage, sum, whole);
  whole.grid = CountGrid::of_parts({&part, 1});
  return whole;
}

void keep_count(CutExchange& cut, CountedCloud& cloud, const SpacingSampler& sampler,
                StageRunner& runner) {
  if (std::exchange(cut.keeps, true)) return;
  by_root(runner, [&] { commit_count(cut, cloud, sampler, runner); });
  if (!runner.communicator.is_root()) cloud.octree = stored_count(cut, runner).octree;
}

BinLog own_log(const CutExchange& cut, const StageRunner& runner) {
  return log_of(cut, runner.store, runner.communicator.rank());
}

void await_bins(const CutExchange& cut, const CountedCloud& cloud, std::uint64_t points_read,
                StageRunner& runner) {
  if (cut.keeps) {
    runner.store.finish_commits();
    runner.communicator.barrier(runner.stop);
    if (!runner.communicator.is_root()) return;
    points_read = points_binned(cut, runner);
  }
  const std::uint64_t expected = cloud.points_read - cloud.rows_left_out;
  if (points_read == expected) return;
  if (cut.keeps) runner.store.discard_stage(cut.stage);
  throw_bad_input("the input changed while it was read",
                  {.file = runner.job.files.front(),
                   .place = {},
                   .found = std::to_string(points_read) + " points",
                   .expected = std::to_string(expected),
                   .advice = "Run the same command again"});
}

void gather_samples(const CutExchange& cut, const StageRunner& runner, SpacingSampler& sampler) {
  if (!runner.communicator.is_root()) return;
  for (int other = 1; other < runner.communicator.size(); ++other) {
    BinLog log = log_of(cut, runner.store, other);
    if (!log.load(sampler).complete) throw CorruptResult(log.spill_file(), kIncomplete);
  }
}

Partition agreed_partition(const CutExchange& cut, const Partition& partition,
                           StageRunner& runner) {
  if (!cut.keeps) return partition;
  by_root(runner, [&] {
    runner.store.commit_document(cut.stage, kMeasured, partition_to_json(partition));
  });
  return runner.communicator.is_root() ? partition : measured_partition(cut, runner);
}

Partition measured_partition(const CutExchange& cut, const StageRunner& runner) {
  return partition_from_json(runner.store.expected_document(cut.stage, kMeasured));
}

std::unique_ptr<PublishedBins> all_bins(const CutExchange& cut, const StageRunner& runner,
                                        const PointSchema& schema) {
  std::vector<PublishedBins::File> files;
  for (int rank = 0; rank < cut.members; ++rank) {
    const BinLog log = log_of(cut, runner.store, rank);
    files.push_back({log.spill_file(), log.load_extents().extents});
  }
  return std::make_unique<PublishedBins>(schema, std::move(files), &runner.store.disk());
}

}  // namespace orbweave
