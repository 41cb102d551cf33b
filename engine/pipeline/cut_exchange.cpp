#include "engine/pipeline/cut_exchange.h"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "io/error.h"

namespace orbweave {
namespace {

using Json = nlohmann::json;

constexpr const char* kCut = "cut";
constexpr const char* kPartition = "partition";
/// Shares whose cells are held at one time while they are put together.
constexpr std::size_t kPartsAtOnce = 8;

// The chunk numbers of what a member leaves; the sum of all counts lies behind them.
ChunkId counts_of(int rank) { return static_cast<ChunkId>(3 * rank); }
ChunkId samples_of(int rank) { return static_cast<ChunkId>(3 * rank + 1); }
ChunkId bins_of(int rank) { return static_cast<ChunkId>(3 * rank + 2); }

std::string bins_name(int rank) { return "bins." + std::to_string(rank); }

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

std::string facts_text(const CountedCloud& cloud) {
  return Json{{"points_read", cloud.points_read},
              {"bytes_read", cloud.bytes_read},
              {"dropped", cloud.dropped},
              {"points_without_view", cloud.points_without_view}}
      .dump();
}

void add_facts(const StoredResult& stored, CountedCloud& cloud) {
  const auto text = stored.read_all<char>("facts");
  const Json facts = Json::parse(text.begin(), text.end());
  cloud.points_read += facts.at("points_read").get<std::uint64_t>();
  cloud.bytes_read += facts.at("bytes_read").get<std::uint64_t>();
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

void commit_samples(ChunkStore& store, const std::string& stage, ChunkId number,
                    std::span<const SpacingSite> sites) {
  std::vector<std::uint64_t> counts;
  std::vector<Vec3> points;
  for (const SpacingSite& site : sites) {
    counts.push_back(site.points.size());
    points.insert(points.end(), site.points.begin(), site.points.end());
  }
  const std::array<ArrayView, 2> arrays = {
      ArrayView{"counts", ScalarType::kUint64, 1, counts.size(), counts.data()},
      ArrayView{"points", ScalarType::kFloat64, 3, points.size(), points.data()}};
  store.commit(stage, number, arrays);
}

void add_samples(const StoredResult& stored, SpacingSampler& sampler) {
  const auto counts = stored.read_all<std::uint64_t>("counts");
  const auto points = stored.read_all<Vec3>("points");
  std::size_t first = 0;
  for (std::size_t site = 0; site < counts.size(); ++site) {
    sampler.add_at_site(site, std::span(points).subspan(first, counts[site]));
    first += counts[site];
  }
}

}  // namespace

static_assert(sizeof(Box) == 6 * sizeof(double) && sizeof(BinExtent) % 8 == 0,
              "stored as rows of 64-bit words");

std::unique_ptr<PointSource> own_share(std::unique_ptr<PointSource> source, const Team& team) {
  if (team.size() == 1) return source;
  const auto rows = source->declared_points();
  const auto size = static_cast<std::uint64_t>(team.size());
  const auto rank = static_cast<std::uint64_t>(team.rank());
  // Whole multiples first: the product of all rows and a rank might overflow.
  const auto begin_of = [&](std::uint64_t r) { return *rows / size * r + *rows % size * r / size; };
  if (rows && source->restrict_rows(begin_of(rank), begin_of(rank + 1) - begin_of(rank)))
    return source;
  if (team.leads()) return source;
  return std::make_unique<NoPoints>(*source);
}

CutExchange::CutExchange(JobContext& context, const std::string& stage)
    : context_(context), stage_(stage + "_cut") {
  by_leader(context_, [&] {
    context_.store.discard_stage(stage_);
    if (!alone()) context_.store.begin_stage(stage_, "for the members of this run");
  });
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

Octree CutExchange::agreed_octree(const Octree& octree) {
  if (alone()) return octree;
  Partition cut;
  cut.octree = octree;
  cut.bounds.extend(octree.root().origin);  // an empty box cannot be written
  return agreed(kCut, cut).octree;
}

void CutExchange::gather_samples(SpacingSampler& sampler) {
  if (alone()) return;
  const int rank = context_.team.rank();
  if (rank != 0) commit_samples(context_.store, stage_, samples_of(rank), sampler.sites());
  context_.store.finish_commits();
  context_.team.meet(context_.stop);
  if (!context_.team.leads()) return;
  for (int other = 1; other < context_.team.size(); ++other)
    add_samples(*context_.store.open(stage_, samples_of(other)), sampler);
}

Partition CutExchange::agreed_partition(const Partition& partition) {
  return alone() ? partition : agreed(kPartition, partition);
}

Partition CutExchange::agreed(const char* name, const Partition& partition) {
  by_leader(context_,
            [&] { context_.store.commit_document(stage_, name, partition_to_json(partition)); });
  return partition_from_json(context_.store.expected_document(stage_, name));
}

std::unique_ptr<PublishedBins> CutExchange::all_bins(Binner& own, const PointSchema& schema) {
  if (alone()) return nullptr;
  const std::vector<BinExtent> extents = own.publish();
  constexpr std::uint32_t kWords = sizeof(BinExtent) / sizeof(std::uint64_t);
  const std::array<ArrayView, 1> arrays = {
      ArrayView{"extents", ScalarType::kUint64, kWords, extents.size(), extents.data()}};
  context_.store.commit(stage_, bins_of(context_.team.rank()), arrays);
  context_.store.finish_commits();
  context_.team.meet(context_.stop);
  std::vector<PublishedBins::File> files;
  for (int rank = 0; rank < context_.team.size(); ++rank) {
    files.push_back({spill_directory() / bins_name(rank),
                     context_.store.open(stage_, bins_of(rank))->read_all<BinExtent>("extents")});
  }
  return std::make_unique<PublishedBins>(schema, std::move(files));
}

std::filesystem::path CutExchange::spill_directory() const {
  return alone() ? context_.store.directory() : context_.store.directory() / stage_;
}

std::string CutExchange::spill_name() const {
  return alone() ? std::string() : bins_name(context_.team.rank());
}

void CutExchange::end() {
  if (alone()) return;
  context_.team.meet(context_.stop);
  by_leader(context_, [&] { context_.store.discard_stage(stage_); });
}

}  // namespace orbweave
