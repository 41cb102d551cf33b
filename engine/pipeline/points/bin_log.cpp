#include "engine/pipeline/points/bin_log.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <utility>

#include "io/store/chunk_store_file.h"
#include "io/system/file_descriptor.h"

namespace orbweave {
namespace {

static_assert(sizeof(BinExtent) % sizeof(std::uint64_t) == 0, "stored as rows of 64-bit words");
constexpr std::uint32_t kExtentWords = sizeof(BinExtent) / sizeof(std::uint64_t);

/// Where a part begins and ends, as it is stored.
struct PartFacts {
  std::uint64_t points_before = 0;
  std::uint64_t points_read = 0;
  std::uint64_t bytes_before = 0;
  std::uint64_t file_bytes = 0;
  std::uint64_t complete = 0;
};
constexpr std::uint32_t kFactWords = sizeof(PartFacts) / sizeof(std::uint64_t);

/// 0 where there is none. File systems over a network may remember the size of a file that is not
/// opened for that.
std::uint64_t size_of_file(const std::filesystem::path& path) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat facts {};
  if (!file.valid() || fstat(file.get(), &facts) != 0) return 0;
  return static_cast<std::uint64_t>(facts.st_size);
}

std::uint64_t end_of(const std::vector<BinExtent>& extents, std::uint64_t end) {
  for (const BinExtent& extent : extents) end = std::max(end, extent.offset + extent.bytes);
  return end;
}

}  // namespace

BinLog::BinLog(ChunkStore& store, std::string stage, int rank, int members, ChunkId first_result)
    : store_(store),
      stage_(std::move(stage)),
      rank_(rank),
      members_(members),
      first_result_(first_result) {}

ChunkId BinLog::number_of(std::uint32_t part) const {
  return first_result_ + part * static_cast<ChunkId>(members_) + static_cast<ChunkId>(rank_);
}

std::filesystem::path BinLog::spill_file() const {
  return store_.directory() / stage_ / ("bins." + std::to_string(rank_));
}

template <class Visit>
BinnedSoFar BinLog::visit_parts(const Visit& visit) const {
  BinnedSoFar so_far;
  const std::uint64_t file_bytes = size_of_file(spill_file());
  for (std::uint32_t part = 0; !so_far.complete && store_.has(stage_, number_of(part)); ++part) {
    try {
      const auto stored = store_.open(stage_, number_of(part));
      PartFacts facts;
      stored->read("facts", 0, 1, &facts);
      // What lies behind a part that was made anew is of an earlier run.
      if (facts.points_before != so_far.points_read || facts.bytes_before != so_far.file_bytes ||
          facts.file_bytes > file_bytes)
        return so_far;
      const auto extents = stored->read_all<BinExtent>("extents");
      visit(*stored);
      so_far.extents.insert(so_far.extents.end(), extents.begin(), extents.end());
      so_far.points_read = facts.points_read;
      so_far.file_bytes = facts.file_bytes;
      so_far.complete = facts.complete != 0;
    } catch (const CorruptResult&) {
      return so_far;
    }
  }
  return so_far;
}

BinnedSoFar BinLog::load_extents() const {
  return visit_parts([](const StoredResult&) {});
}

BinnedSoFar BinLog::load(SpacingSampler& sampler) {
  parts_ = 0;
  BinnedSoFar so_far = visit_parts([&](const StoredResult& stored) {
    const auto counts = stored.read_all<std::uint64_t>("counts");
    const auto points = stored.read_all<Vec3>("points");
    const auto scans = stored.read_all<std::uint32_t>("scans");
    std::size_t first = 0;
    for (std::size_t site = 0; site < counts.size(); ++site) {
      const auto own_scans = scans.empty() ? std::span<const std::uint32_t>()
                                           : std::span(scans).subspan(first, counts[site]);
      sampler.add_at_site(site, std::span(points).subspan(first, counts[site]), own_scans);
      first += counts[site];
    }
    ++parts_;
  });
  points_read_ = so_far.points_read;
  file_bytes_ = so_far.file_bytes;
  // Should the file grow again, a part that does not count now would seem to.
  if (!so_far.complete) store_.discard(stage_, number_of(parts_));
  sampled_.clear();
  for (const SpacingSite& site : sampler.sites()) sampled_.push_back(site.points.size());
  return so_far;
}

void BinLog::append(std::uint64_t points_read, const std::vector<BinExtent>& extents,
                    const SpacingSampler& sampler, bool complete) {
  const PartFacts facts = {std::exchange(points_read_, points_read), points_read, file_bytes_,
                           end_of(extents, file_bytes_), complete ? 1u : 0u};
  file_bytes_ = facts.file_bytes;
  sampled_.resize(sampler.sites().size());
  std::vector<std::uint64_t> counts;
  for (std::size_t i = 0; i < sampled_.size(); ++i)
    counts.push_back(sampler.sites()[i].points.size() - sampled_[i]);
  std::vector<Vec3> points;
  std::vector<std::uint32_t> scans;
  points.reserve(std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}));
  for (std::size_t i = 0; i < sampled_.size(); ++i) {
    const std::vector<Vec3>& all = sampler.sites()[i].points;
    points.insert(points.end(), all.begin() + static_cast<std::ptrdiff_t>(sampled_[i]), all.end());
    if (!sampler.scans().empty()) {
      const std::vector<std::uint32_t>& own = sampler.scans()[i];
      scans.insert(scans.end(), own.begin() + static_cast<std::ptrdiff_t>(sampled_[i]), own.end());
    }
    sampled_[i] = all.size();
  }
  const std::array<ArrayView, 5> arrays = {
      ArrayView{"facts", ScalarType::kUint64, kFactWords, 1, &facts},
      ArrayView{"extents", ScalarType::kUint64, kExtentWords, extents.size(), extents.data()},
      ArrayView{"counts", ScalarType::kUint64, 1, counts.size(), counts.data()},
      ArrayView{"points", ScalarType::kFloat64, 3, points.size(), points.data()},
      ArrayView{"scans", ScalarType::kUint32, 1, scans.size(), scans.data()}};
  store_.discard(stage_, number_of(parts_ + 1));
  store_.commit(stage_, number_of(parts_++), arrays);
}

}  // namespace orbweave
