// A chunk's triangles as the store has them, and the numbers of their vertices in the mesh file.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "engine/pipeline/output/output_numbers.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/stitching/local_numbers.h"

namespace orbweave {

/// Vertices of other chunks are looked up once for the chunk, not for every corner.
class ChunkNumbers {
 public:
  /// Reads which vertices of others the chunk uses. `numbers` must outlive the object.
  ChunkNumbers(const ChunkStore& store, const Partition& partition, ChunkId chunk,
               const OutputNumbers& numbers);
  ChunkNumbers(const ChunkNumbers&) = delete;
  ChunkNumbers& operator=(const ChunkNumbers&) = delete;

  const LocalNumbers& local() const { return local_; }
  /// A stored triangle as the file has it. `ranks`: the caller's own.
  Triangle64 of(const Triangle& t, VertexRanks& ranks) const {
    Triangle64 result;
    for (int k = 0; k < 3; ++k) result[k] = value_of(of_vertex(LocalVertex{t[k]}, ranks));
    if (splits_) take_copies(local_.global(t), result);
    return result;
  }

 private:
  OutputVertex of_vertex(LocalVertex vertex, VertexRanks& ranks) const {
    const std::uint32_t local = value_of(vertex);
    if (local >= local_.own()) return outer_numbers_[local - local_.own()];
    if (all_used_) return OutputVertex{first_number_ + local};
    return ranks.of(local_.global(local));
  }
  void take_copies(const Triangle64& t, Triangle64& result) const {
    for (int k = 0; k < 3; ++k) {
      const SplitCorner* split = numbers_.split_of(t, t[k]);
      if (split != nullptr) result[k] = value_of(numbers_.of_copy(*split));
    }
  }

  const OutputNumbers& numbers_;
  std::vector<std::uint64_t> outer_;
  LocalNumbers local_;
  std::vector<OutputVertex> outer_numbers_;
  std::uint64_t first_number_ = 0;
  bool all_used_ = false;
  bool splits_ = false;
};

/// Those of the chunks that were asked for last: pieces of one chunk share them. Thread-safe.
class RecentChunkNumbers {
 public:
  /// Everything must outlive the object.
  RecentChunkNumbers(const ChunkStore& store, const Partition& partition,
                     const OutputNumbers& numbers)
      : store_(store), partition_(partition), numbers_(numbers) {}
  std::shared_ptr<const ChunkNumbers> of(ChunkId chunk);

 private:
  /// Pieces come in order: those in flight are of few chunks, or of small ones.
  static constexpr std::size_t kKept = 4;

  const ChunkStore& store_;
  const Partition& partition_;
  const OutputNumbers& numbers_;
  std::mutex mutex_;
  std::list<std::pair<ChunkId, std::shared_ptr<const ChunkNumbers>>> recent_;
};

}  // namespace orbweave
