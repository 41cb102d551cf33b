// Which points the mesh uses, and the number each of them gets in the output file. What is kept of
// that is a count per block of points; the points of a block are read from the chunk's mesh when
// one of them is asked for, and not even then where the mesh uses them all.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/surface/vertex_numbering.h"
#include "io/store/chunk_store.h"

namespace orbweave {

/// Which of some points are used, and how many of those come before each: 1.5 bits a point, fewer
/// than 2^32 points.
class RankedPoints {
 public:
  explicit RankedPoints(std::uint64_t points)
      : bits_(points / 64 + 1, 0), before_(bits_.size() + 1, 0) {}

  /// Points are used where fans is not 0.
  void mark(std::span<const std::uint8_t> fans) {
    for (std::size_t i = 0; i < fans.size(); ++i) {
      bits_[i / 64] |= std::uint64_t{fans[i] != 0 ? 1u : 0u} << (i % 64);
    }
  }
  /// The point is not used after all.
  void unmark(std::uint64_t point) { bits_[point / 64] &= ~(std::uint64_t{1} << (point % 64)); }
  /// Call once, after the last mark.
  void number() {
    for (std::size_t word = 0; word < bits_.size(); ++word) {
      before_[word + 1] = before_[word] + ones(bits_[word]);
    }
  }
  bool used(std::uint64_t point) const { return (bits_[point / 64] >> (point % 64) & 1) != 0; }
  std::uint64_t count() const { return before_.back(); }
  /// How many used points come before this one; `point` may be one past the last.
  std::uint64_t rank(std::uint64_t point) const {
    const std::uint64_t below = (std::uint64_t{1} << (point % 64)) - 1;
    const std::uint64_t word = bits_[point / 64] & below;
    // On most surfaces nearly every point is used: then there is nothing to count.
    return before_[point / 64] + (word == below ? point % 64 : ones(word));
  }

 private:
  static std::uint32_t ones(std::uint64_t word) {
    return static_cast<std::uint32_t>(std::popcount(word));
  }

  std::vector<std::uint64_t> bits_;
  std::vector<std::uint32_t> before_;
};

/// Points that follow each other in a chunk.
struct UsedBlock {
  std::uint64_t first = 0;  ///< the first point's number in the cloud
  std::uint64_t points = 0;
  std::uint64_t before = 0;                   ///< used points of the cloud before the first
  std::shared_ptr<const RankedPoints> ranks;  ///< null: all are used

  bool holds(std::uint64_t vertex) const { return vertex - first < points; }
  std::uint64_t rank(std::uint64_t vertex) const {
    return before + (ranks == nullptr ? vertex - first : ranks->rank(vertex - first));
  }
};

/// Points of a block; a chunk's last one has fewer.
inline constexpr std::uint64_t kUsedBlockPoints = std::uint64_t{1} << 16;

/// Adds how many points of each of a chunk's blocks are used.
void append_used_counts(std::span<const std::uint8_t> fans, std::vector<std::uint32_t>& counts);

/// The used points of a cloud: 8 bytes per block, and some megabytes for the blocks that were read
/// last. Thread-safe.
class UsedVertices {
 public:
  /// `counts`: those of all chunks, one after the other. `freed`: points that are not used after
  /// all, ascending. Store, partition and `freed` must outlive the object.
  UsedVertices(const ChunkStore& store, const Partition& partition,
               std::span<const std::uint32_t> counts, std::span<const std::uint64_t> freed);

  std::uint64_t count() const { return before_.back(); }
  std::uint64_t before_chunk(ChunkId chunk) const { return before_[first_block_[chunk]]; }
  /// Used points in the block of a chunk that begins with row `first`. Reads nothing.
  std::uint64_t used_in_block(ChunkId chunk, std::uint64_t first) const {
    const std::size_t block = number_of(chunk, first);
    return before_[block + 1] - before_[block];
  }
  /// The block of a chunk's point. Throws CorruptResult where the chunk's mesh is damaged.
  UsedBlock block(ChunkId chunk, std::uint64_t row) const;
  UsedBlock block_of(std::uint64_t vertex) const;

 private:
  struct Cached {
    std::size_t block = 0;
    std::uint64_t last_use = 0;
    std::shared_ptr<const RankedPoints> ranks;
  };

  std::size_t number_of(ChunkId chunk, std::uint64_t row) const {
    return first_block_[chunk] + static_cast<std::size_t>(row / kUsedBlockPoints);
  }
  std::shared_ptr<const RankedPoints> find(std::size_t block) const;
  std::shared_ptr<const RankedPoints> load(ChunkId chunk, std::uint64_t first_row,
                                           std::uint64_t points) const;
  void keep(std::size_t block, std::shared_ptr<const RankedPoints> ranks) const;

  const ChunkStore& store_;
  const Partition& partition_;
  std::span<const std::uint64_t> freed_;
  std::vector<std::size_t> first_block_;  ///< of each chunk, and the number of blocks
  std::vector<std::uint64_t> before_;     ///< used points before each block, and all
  mutable std::mutex mutex_;
  mutable std::vector<Cached> cache_;
  mutable std::uint64_t uses_ = 0;
};

/// Numbers in the output of canonical vertices that lie near each other: keeps the blocks at hand.
/// For one thread.
class VertexRanks {
 public:
  /// `used` must outlive the object.
  explicit VertexRanks(const UsedVertices& used) : used_(used) {}
  VertexRanks(const VertexRanks&) = delete;
  VertexRanks& operator=(const VertexRanks&) = delete;

  OutputVertex of(std::uint64_t vertex) {
    const UsedBlock*& block = recent_[vertex / kRun % kRecent];
    if (block == nullptr || !block->holds(vertex)) block = find(vertex);
    return OutputVertex{block->rank(vertex)};
  }

 private:
  static constexpr std::uint64_t kRun = 4096;
  static constexpr std::size_t kRecent = 256;
  static constexpr std::size_t kMostHeld = 32;
  const UsedBlock* find(std::uint64_t vertex);

  const UsedVertices& used_;
  std::vector<UsedBlock> held_;  // its capacity never changes
  std::array<const UsedBlock*, kRecent> recent_{};
};

}  // namespace orbweave
