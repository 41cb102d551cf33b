#include "engine/pipeline/output/chunk_numbers.h"

#include "engine/pipeline/surface/stored_mesh.h"

namespace orbweave {

ChunkNumbers::ChunkNumbers(const ChunkStore& store, const Partition& partition, ChunkId chunk,
                           const OutputNumbers& numbers)
    : numbers_(numbers),
      outer_(store.open(kMeshStage, chunk)->read_all<std::uint64_t>(kStoredOuter)),
      local_(partition.first_vertex[chunk], partition.points_in(chunk), outer_),
      first_number_(numbers.used().before_chunk(chunk)),
      all_used_(numbers.used().before_chunk(chunk + 1) - first_number_ == local_.own()),
      splits_(numbers.any_split()) {
  VertexRanks ranks(numbers.used());
  outer_numbers_.reserve(outer_.size());
  for (const std::uint64_t vertex : outer_) outer_numbers_.push_back(ranks.of(vertex));
}

std::shared_ptr<const ChunkNumbers> RecentChunkNumbers::of(ChunkId chunk) {
  // Held while they are made: who asks for the same chunk waits rather than makes them again.
  const std::scoped_lock lock(mutex_);
  for (const auto& [known, numbers] : recent_) {
    if (known == chunk) return numbers;
  }
  auto made = std::make_shared<const ChunkNumbers>(store_, partition_, chunk, numbers_);
  recent_.emplace_front(chunk, made);
  if (recent_.size() > kKept) recent_.pop_back();
  return made;
}

}  // namespace orbweave
