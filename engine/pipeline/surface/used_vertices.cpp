#include "engine/pipeline/surface/used_vertices.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "engine/pipeline/surface/stored_mesh.h"

namespace orbweave {
namespace {

/// Blocks that are kept after they were read: 12 KiB each.
constexpr std::size_t kMostCached = 256;

}  // namespace

void append_used_counts(std::span<const std::uint8_t> fans, std::vector<std::uint32_t>& counts) {
  for (std::size_t first = 0; first < fans.size(); first += kUsedBlockPoints) {
    const auto block = fans.subspan(first, std::min(kUsedBlockPoints, fans.size() - first));
    const auto unused = std::count(block.begin(), block.end(), std::uint8_t{0});
    counts.push_back(static_cast<std::uint32_t>(block.size() - static_cast<std::size_t>(unused)));
  }
}

UsedVertices::UsedVertices(const ChunkStore& store, const Partition& partition,
                           std::span<const std::uint32_t> counts,
                           std::span<const std::uint64_t> freed)
    : store_(store), partition_(partition), freed_(freed), first_block_{0}, before_{0} {
  auto next_freed = freed.begin();
  for (ChunkId chunk = 0; chunk + 1 < partition.first_vertex.size(); ++chunk) {
    const std::uint64_t points = partition.points_in(chunk);
    for (std::uint64_t first = 0; first < points; first += kUsedBlockPoints) {
      if (before_.size() > counts.size())
        throw std::logic_error("there are more blocks of points than counts");
      const std::uint64_t end =
          partition.first_vertex[chunk] + std::min(points, first + kUsedBlockPoints);
      const auto end_of_freed = std::lower_bound(next_freed, freed.end(), end);
      before_.push_back(before_.back() + counts[before_.size() - 1] -
                        static_cast<std::uint64_t>(end_of_freed - next_freed));
      next_freed = end_of_freed;
    }
    first_block_.push_back(before_.size() - 1);
  }
}

UsedBlock UsedVertices::block(ChunkId chunk, std::uint64_t row) const {
  const std::size_t number = number_of(chunk, row);
  const std::uint64_t first_row = row - row % kUsedBlockPoints;
  UsedBlock block{partition_.first_vertex[chunk] + first_row,
                  std::min(kUsedBlockPoints, partition_.points_in(chunk) - first_row),
                  before_[number],
                  {}};
  if (before_[number + 1] - before_[number] == block.points) return block;
  block.ranks = find(number);
  if (block.ranks == nullptr) {
    block.ranks = load(chunk, first_row, block.points);
    keep(number, block.ranks);
  }
  return block;
}

UsedBlock UsedVertices::block_of(std::uint64_t vertex) const {
  const ChunkId chunk = partition_.chunk_of(vertex);
  return block(chunk, vertex - partition_.first_vertex[chunk]);
}

std::shared_ptr<const RankedPoints> UsedVertices::find(std::size_t block) const {
  const std::scoped_lock lock(mutex_);
  for (Cached& cached : cache_) {
    if (cached.block != block) continue;
    cached.last_use = ++uses_;
    return cached.ranks;
  }
  return nullptr;
}

std::shared_ptr<const RankedPoints> UsedVertices::load(ChunkId chunk, std::uint64_t first_row,
                                                       std::uint64_t points) const {
  std::vector<std::uint8_t> fans(points);
  store_.open(kMeshStage, chunk)->read("fans", first_row, points, fans.data());
  auto ranks = std::make_shared<RankedPoints>(points);
  ranks->mark(fans);
  const std::uint64_t first = partition_.first_vertex[chunk] + first_row;
  for (auto at = std::lower_bound(freed_.begin(), freed_.end(), first);
       at != freed_.end() && *at - first < points; ++at) {
    ranks->unmark(*at - first);
  }
  ranks->number();
  return ranks;
}

/// Two threads may have read the same block: one of the two is kept twice until it is dropped.
void UsedVertices::keep(std::size_t block, std::shared_ptr<const RankedPoints> ranks) const {
  const std::scoped_lock lock(mutex_);
  if (cache_.size() < kMostCached) {
    cache_.push_back({block, ++uses_, std::move(ranks)});
    return;
  }
  const auto oldest =
      std::min_element(cache_.begin(), cache_.end(),
                       [](const Cached& a, const Cached& b) { return a.last_use < b.last_use; });
  *oldest = {block, ++uses_, std::move(ranks)};
}

const UsedBlock* VertexRanks::find(std::uint64_t vertex) {
  for (const UsedBlock& block : held_)
    if (block.holds(vertex)) return &block;
  if (held_.size() == kMostHeld) {
    held_.clear();
    recent_.fill(nullptr);
  }
  held_.reserve(kMostHeld);
  return &held_.emplace_back(used_.block_of(vertex));
}

}  // namespace orbweave
