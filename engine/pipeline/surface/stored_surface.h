// The stitched mesh as the hole pass sees it, read from the chunk store chunk by chunk as it is
// asked for, in bounded memory.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/holes/patch/box_tree.h"
#include "engine/holes/problem/surface.h"
#include "engine/pipeline/stage/partition.h"
#include "io/store/chunk_store.h"

namespace orbweave {

class StoredSurface : public Surface {
 public:
  /// `reach`: no triangle has an edge longer than that. `memory_bytes`: what the chunks kept may
  /// hold, one that is being read included; those in use (two per thread) are held beyond it.
  /// `with_values`: whether the vertices' attributes are wanted.
  StoredSurface(const ChunkStore& store, const Partition& partition, double reach,
                std::size_t memory_bytes, bool with_values);
  ~StoredSurface() override;

  /// Triangles that no longer count, sorted. Not while others ask.
  void remove(std::vector<Triangle64> triangles) { removed_ = std::move(triangles); }
  const std::vector<Triangle64>& removed() const { return removed_; }

  /// From now on the chunks kept may hold that much. Not while others ask.
  void limit_memory(std::size_t memory_bytes);
  /// What a chunk takes of that.
  std::size_t chunk_bytes(ChunkId chunk) const;

  Vec3 position(std::uint64_t vertex) const override;
  void triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const override;
  void positions(std::span<const std::uint64_t> vertices, std::span<Vec3> out) const override;
  void triangles_at(std::span<const std::uint64_t> vertices, std::vector<Triangle64>& out,
                    std::vector<std::size_t>& ends) const override;
  /// The points of a chunk, in their order.
  std::vector<Vec3> positions_of(ChunkId chunk) const;
  /// Adds the triangles that the chunk owns.
  void triangles_of(ChunkId chunk, std::vector<Triangle64>& out) const;
  /// Adds those of the triangles that the chunk owns that may meet one of the places.
  void triangles_near(ChunkId chunk, const BoxTree& places, std::vector<Triangle64>& out) const;
  std::uint32_t channels() const override;
  std::vector<double> values(std::span<const std::uint64_t> vertices) const override;

 private:
  struct LoadedChunk;
  class Cache;

  const ChunkStore& store_;
  const Partition& partition_;
  double reach_;
  bool with_values_;
  std::vector<Triangle64> removed_;
  std::unique_ptr<Cache> cache_;
};

}  // namespace orbweave
