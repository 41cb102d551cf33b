#include "engine/pipeline/cut_exchange.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>
#include <vector>

#include "engine/pipeline/stage_keys.h"
#include "io/error.h"

namespace orbweave {
namespace {

using Json = nlohmann::json;

/// How the points are cut, once they are counted.
constexpr const char* kCounted = "counted";
/// What is known of them once they are binned.
constexpr const char* kMeasured = "measured";
/// What is found where a log that was complete no longer is.
constexpr const char* kIncomplete = "damage to the file, or to the log of what lies in it";
/// Shares whose cells are held at one time while they are put together.
constexpr std::size_t kPartsAtOnce = 8;

// The numbers of what lies in the stage: the counts of every member, their sum, the sites of the
// sampler, and then the parts of the members' logs.
ChunkId counts_of(int rank) { return static_cast<ChunkId>(rank); }
ChunkId first_of_logs(int members) { return static_cast<ChunkId>(members + 2); }

class NoPoints final : public PointSource {
 public:
  explicit NoPoints(const PointSource& like)
      : schema_(like.schema()), coordinate_system_(like.coordinate_system()) {}
  const PointSchema& schema() const override { return schema_; }
  std::optional<std::uint64_t> declared_points() const override { return 0; }
  bool read(PointCloud& batch, std::size_t /*capacity*/) override {
    batch.clear();
    batch.schema = schema_;
    return false;
  }
  std::uint64_t bytes_read() const override { return 0; }
  std::uint64_t bytes_total() const override { return 0; }
  std::string coordinate_system() const override { return coordinate_system_; }

 private:
  PointSchema schema_;
  std::string coordinate_system_;
};

/// A source without its first points.
class RestOfPoints final : public PointSource {
 public:
  RestOfPoints(std::unique_ptr<PointSource> source, std::uint64_t skipped)
      : source_(std::move(source)), to_skip_(skipped) {}
  const PointSchema& schema() const override { return source_->schema(); }
  std::optional<std::uint64_t> declared_points() const override { return std::nullopt; }
  bool read(PointCloud& batch, std::size_t capacity) override {
    while (source_->read(batch, capacity)) {
      const std::uint64_t skipped = std::min<std::uint64_t>(to_skip_, batch.size());
      to_skip_ -= skipped;
      if (skipped == batch.size()) continue;
      if (skipped > 0) batch = without_first(batch, skipped);
      return true;
    }
    return false;
  }
  std::uint64_t bytes_read() const override { return source_->bytes_read(); }
  std::uint64_t bytes_total() const override { return source_->bytes_total(); }
  std::optional<ScannerPlace> scanner() const override { return source_->scanner(); }
  DroppedPoints left_out() const override { return source_->left_out(); }
  std::string coordinate_system() const override { return source_->coordinate_system(); }

 private:
  static PointCloud without_first(const PointCloud& batch, std::uint64_t count) {
    PointCloud rest;
    rest.schema = batch.schema;
    for (std::uint64_t i = count; i < batch.size(); ++i) rest.append(batch, i);
    return rest;
  }

  std::unique_ptr<PointSource> source_;
  std::uint64_t to_skip_;
};

std::string facts_text(const CountedCloud& cloud) {
  return Json{{"points_read", cloud.points_read},
              {"bytes_read", cloud.bytes_read},
              {"rows_left_out", cloud.rows_left_out},
              {"dropped", cloud.dropped},
              {"points_without_view", cloud.points_without_view}}
      .dump();
}

void add_facts(const StoredResult& stored, CountedCloud& cloud) {
  const auto text = stored.read_all<char>("facts");
  const Json facts = Json::parse(text.begin(), text.end());
  cloud.points_read += facts.at("points_read").get<std::uint64_t>();
  cloud.bytes_read += facts.at("bytes_read").get<std::uint64_t>();
  cloud.rows_left_out += facts.at("rows_left_out").get<std::uint64_t>();
  cloud.points_without_view += facts.at("points_without_view").get<std::uint64_t>();
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
  return Json{{"members", members},
              {"chunk_points", cloud.memory.chunk_points},
              {"rows_left_out", cloud.rows_left_out},
              {"bytes_read", cloud.bytes_read},
              {"cut", partition_to_json(cut)}}
      .dump();
}

std::uint64_t counted_points(const Octree& octree) {
  std::uint64_t points = 0;
  for (const Chunk& chunk : octree.chunks()) points += chunk.points;
  return points;
}

}  // namespace

static_assert(sizeof(Box) == 6 * sizeof(double), "stored as rows of 64-bit words");

std::string cut_stage_of(const std::string& stage) { return stage + "_cut"; }

std::unique_ptr<PointSource> own_share(std::unique_ptr<PointSource> source, const Team& team,
                                       std::uint64_t read_before, bool rows_are_points) {
  const bool leaps = read_before > 0 && rows_are_points && source->has_row_access();
  const std::uint64_t leap = leaps ? read_before : 0;
  if (team.size() > 1 || leaps) {
    const auto rows = source->declared_points();
    const auto size = static_cast<std::uint64_t>(team.size());
    const auto rank = static_cast<std::uint64_t>(team.rank());
    // Whole multiples first: the product of all rows and a rank might overflow.
    const auto begin_of = [&](std::uint64_t r) {
      return *rows / size * r + *rows % size * r / size;
    };
    const auto restrict = [&] {
      const std::uint64_t share = begin_of(rank + 1) - begin_of(rank);
      return source->restrict_rows(begin_of(rank) + leap, share - std::min(leap, share));
    };
    const bool shared = rows&& restrict();
    if (leaps && shared) return source;
    if (!shared && !team.leads()) return std::make_unique<NoPoints>(*source);
  }
  if (read_before == 0) return source;
  return std::make_unique<RestOfPoints>(std::move(source), read_before);
}

CutExchange::CutExchange(JobContext& context, const CloudInput& input)
    : context_(context), stage_(cut_stage_of(input.stage)), members_(context.team.size()) {
  if (context_.team.leads()) {
    key_ = context_.store.key(input.stage).value_or("") + input.order +
           key_line("layout of bins", "1");
    found_ = examine(key_);
    if (found_ == Found::kNothing) context_.store.discard_stage(stage_);
    if (!alone()) context_.store.begin_stage(stage_, key_);
  }
  found_ = static_cast<Found>(
      context_.team.leaders_word(static_cast<std::uint64_t>(found_), context_.stop));
  kept_ = found_ != Found::kNothing;
  if (!kept_) return;
  members_ = Json::parse(context_.store.expected_document(stage_, kCounted)).at("members");
  context_.team.meet(context_.stop);  // what is there changes only when all have seen it
}

/// How much of what lies there can be used by this run; the rest of it goes.
CutExchange::Found CutExchange::examine(const std::string& key) {
  ChunkStore& store = context_.store;
  const auto document = store.document(stage_, kCounted);
  if (!document || !store.has_key(stage_, key)) return Found::kNothing;
  const Json facts = Json::parse(*document);
  members_ = facts.at("members");
  const Partition cut = partition_from_json(facts.at("cut").get<std::string>());
  std::uint64_t largest = 0;
  for (const Chunk& chunk : cut.octree.chunks()) largest = std::max(largest, chunk.points);
  const std::string reason = reason_not_to_fit(context_, cut.memory_bytes, largest,
                                               counted_points(cut.octree), cut.schema);
  if (!reason.empty()) {
    context_.note(reason + ": they are cut again");
    members_ = context_.team.size();
    return Found::kNothing;
  }
  if (store.document(stage_, kMeasured)) {
    if (bins_are_whole()) return Found::kBinned;
    context_.note("points that were binned are damaged or gone: they are read again");
  }
  const int before = std::exchange(members_, context_.team.size());
  try {
    CountedCloud cloud = counted();
    if (members_ == before) {
      sampler();
      return Found::kCounted;
    }
    // Shares are others now. The count stays.
    members_ = before;
    const SpacingSampler sites = sampler();
    members_ = context_.team.size();
    store.discard_stage(stage_);
    store.begin_stage(stage_, key);
    commit_count(cloud, sites);
    return Found::kCounted;
  } catch (const CorruptResult&) {
    members_ = context_.team.size();
    return Found::kNothing;
  }
}

bool CutExchange::bins_are_whole() const {
  for (int rank = 0; rank < members_; ++rank)
    if (!log_of(rank).load_extents().complete) return false;
  return true;
}

BinLog CutExchange::log_of(int rank) const {
  return BinLog(context_.store, stage_, rank, members_, first_of_logs(members_));
}

CountedCloud CutExchange::counted() const {
  const Json facts = Json::parse(context_.store.expected_document(stage_, kCounted));
  Partition cut = partition_from_json(facts.at("cut").get<std::string>());
  CountedCloud cloud;
  cloud.schema = std::move(cut.schema);
  cloud.points_read = cut.points_read;
  cloud.points_used = counted_points(cut.octree);
  cloud.bytes_read = facts.at("bytes_read");
  cloud.rows_left_out = facts.at("rows_left_out");
  cloud.dropped = std::move(cut.dropped);
  cloud.points_without_view = cut.points_without_view;
  cloud.coordinate_system = std::move(cut.coordinate_system);
  cloud.bounds = cut.bounds;
  cloud.octree = std::move(cut.octree);
  const auto size = static_cast<std::uint64_t>(context_.team.size());
  cloud.own_share = cloud.points_read / size;
  cloud.memory = plan_memory(context_.job.partition.memory_bytes, cloud.points_used / size,
                             context_.threads(), context_.job.partition.chunk_points, cloud.schema);
  cloud.memory.chunk_points = facts.at("chunk_points");
  return cloud;
}

SpacingSampler CutExchange::sampler() const {
  const auto boxes = context_.store.open(stage_, sites_number())->read_all<Box>("sites");
  std::vector<SpacingSite> sites;
  for (std::size_t i = 0; i + 1 < boxes.size(); i += 2)
    sites.push_back({boxes[i], boxes[i + 1], {}});
  return SpacingSampler(std::move(sites), counted().points_used);
}

CountedCloud CutExchange::whole_cloud(CountedCloud share) {
  if (alone()) return share;
  commit_counts(context_.store, stage_, counts_of(context_.team.rank()), share);
  context_.store.finish_commits();
  context_.team.meet(context_.stop);
  const ChunkId sum = counts_of(context_.team.size());
  by_leader(context_, [&] {
    commit_counts(context_.store, stage_, sum, gather_counts());
    context_.store.finish_commits();
  });
  CountedCloud whole;
  whole.schema = std::move(share.schema);
  whole.coordinate_system = std::move(share.coordinate_system);
  whole.notes = std::move(share.notes);
  whole.own_share = share.own_share;
  const CountGrid::Part part = load_counts(context_.store, stage_, sum, whole);
  whole.grid = CountGrid::of_parts({&part, 1});
  return whole;
}

CountedCloud CutExchange::gather_counts() {
  CountedCloud whole;
  std::vector<CountGrid::Part> parts;
  for (int rank = 0; rank < context_.team.size(); ++rank) {
    parts.push_back(load_counts(context_.store, stage_, counts_of(rank), whole));
    if (parts.size() < kPartsAtOnce) continue;
    parts = {CountGrid::of_parts(parts).part()};
  }
  whole.grid = CountGrid::of_parts(parts);
  return whole;
}

void CutExchange::commit_count(const CountedCloud& cloud, const SpacingSampler& sampler) {
  context_.store.begin_stage(stage_, key_);
  commit_sites(context_.store, stage_, sites_number(), sampler.sites());
  context_.store.finish_commits();
  context_.store.commit_document(
      stage_, kCounted, counted_text(cloud, context_.job.partition.memory_bytes, members_));
}

void CutExchange::keep_count(CountedCloud& cloud, const SpacingSampler& sampler) {
  if (std::exchange(kept_, true)) return;
  by_leader(context_, [&] { commit_count(cloud, sampler); });
  if (!context_.team.leads()) cloud.octree = counted().octree;
}

void CutExchange::await_bins(const CountedCloud& cloud, std::uint64_t points_read) {
  if (kept_) {
    context_.store.finish_commits();
    context_.team.meet(context_.stop);
    if (!context_.team.leads()) return;
    points_read = 0;
    for (int rank = 0; rank < members_; ++rank) {
      const BinLog log = log_of(rank);
      const BinnedSoFar binned = log.load_extents();
      if (!binned.complete) throw CorruptResult(log.spill_file(), kIncomplete);
      points_read += binned.points_read;
    }
  }
  const std::uint64_t expected = cloud.points_read - cloud.rows_left_out;
  if (points_read == expected) return;
  if (kept_) context_.store.discard_stage(stage_);
  throw_bad_input("the input changed while it was read",
                  {.file = context_.files.front(),
                   .place = {},
                   .found = std::to_string(points_read) + " points",
                   .expected = std::to_string(expected),
                   .advice = "Run the same command again"});
}

void CutExchange::gather_samples(SpacingSampler& sampler) const {
  if (!context_.team.leads()) return;
  for (int other = 1; other < context_.team.size(); ++other) {
    BinLog log = log_of(other);
    if (!log.load(sampler).complete) throw CorruptResult(log.spill_file(), kIncomplete);
  }
}

Partition CutExchange::agreed_partition(const Partition& partition) {
  if (!kept_) return partition;
  by_leader(context_, [&] {
    context_.store.commit_document(stage_, kMeasured, partition_to_json(partition));
  });
  return context_.team.leads() ? partition : measured();
}

Partition CutExchange::measured() const {
  return partition_from_json(context_.store.expected_document(stage_, kMeasured));
}

std::unique_ptr<PublishedBins> CutExchange::all_bins(const PointSchema& schema) const {
  std::vector<PublishedBins::File> files;
  for (int rank = 0; rank < members_; ++rank) {
    const BinLog log = log_of(rank);
    files.push_back({log.spill_file(), log.load_extents().extents});
  }
  return std::make_unique<PublishedBins>(schema, std::move(files), &context_.store.disk());
}

}  // namespace orbweave
