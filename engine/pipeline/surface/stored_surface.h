// The stitched mesh as the hole pass sees it, read from the chunk store chunk by chunk as it is
// asked for, in bounded memory.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/holes/patch/box_tree.h"
#include "engine/holes/problem/surface.h"
#include "engine/pipeline/stage/partition.h"
#include "io/stop_token.h"
#include "io/store/chunk_store.h"

namespace orbweave {

/// Which vertices triangles may have: most vertices that others have are told apart by one bit.
/// Vertices near one another have their bits in one word.
class VertexFilter {
 public:
  VertexFilter() = default;
  explicit VertexFilter(std::span<const Triangle64> triangles) {
    if (triangles.empty()) return;
    constexpr std::size_t kBitsPerCorner = 8;
    bits_.resize(std::bit_ceil(3 * kBitsPerCorner * triangles.size() / 64 + 1));
    for (const Triangle64& t : triangles)
      for (const std::uint64_t vertex : t) bits_[word_of(vertex)] |= bit_of(vertex);
  }
  bool may_have(std::uint64_t vertex) const {
    return !bits_.empty() && (bits_[word_of(vertex)] & bit_of(vertex)) != 0;
  }

 private:
  static std::uint64_t bit_of(std::uint64_t vertex) { return std::uint64_t{1} << (vertex % 64); }
  std::size_t word_of(std::uint64_t vertex) const {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;
    return static_cast<std::size_t>((vertex / 64 * kGolden) >> 32) & (bits_.size() - 1);
  }

  std::vector<std::uint64_t> bits_;
};

/// A vertex that was asked for, and a triangle there.
struct TriangleAt {
  std::uint64_t vertex = 0;
  Triangle64 triangle{};
  auto operator<=>(const TriangleAt&) const = default;
};

class StoredSurface : public Surface {
 public:
  /// `reach`: no triangle has an edge longer than that. `memory_bytes`: what the chunks kept may
  /// hold, one that is being read included; those in use (two per thread) are held beyond it.
  /// `with_values`: whether the vertices' attributes are wanted.
  StoredSurface(const ChunkStore& store, const Partition& partition, double reach,
                std::size_t memory_bytes, bool with_values);
  ~StoredSurface() override;

  /// Triangles that no longer count, sorted. Not while others ask.
  void remove(std::vector<Triangle64> triangles) {
    removed_ = std::move(triangles);
    removed_at_ = VertexFilter(removed_);
  }
  const std::vector<Triangle64>& removed() const { return removed_; }

  /// From now on the chunks kept may hold that much. Not while others ask.
  void limit_memory(std::size_t memory_bytes);
  /// What a chunk takes of that.
  std::size_t chunk_bytes(ChunkId chunk) const;

  bool is_at_hand() const override { return partition_.octree.chunks().size() == 1; }
  Vec3 position(std::uint64_t vertex) const override;
  void triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const override;
  void positions(std::span<const std::uint64_t> vertices, std::span<Vec3> out) const override;
  void triangles_at(std::span<const std::uint64_t> vertices, std::vector<Triangle64>& out,
                    std::vector<std::size_t>& ends) const override;
  void new_triangles_at(std::span<const std::uint64_t> vertices, TriangleMarks& met,
                        std::vector<Triangle64>& out) const override;
  /// The triangles at vertices (ascending) that lie all over the surface, sorted. Reads the
  /// triangles of each chunk at most once and keeps no chunk, whatever the order of the vertices.
  std::vector<TriangleAt> collect_triangles_at(std::span<const std::uint64_t> vertices,
                                               const StopToken& stop) const;
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

  bool is_removed(const Triangle64& triangle) const;
  /// Calls visit(chunk, what is loaded of it, vertex) for each vertex, which ascend, and each chunk
  /// that may own triangles there, and after each vertex end(vertex).
  template <class Visit, class End>
  void visit_chunks_at(std::span<const std::uint64_t> vertices, const Visit& visit,
                       const End& end) const;
  void collect_of_chunk(ChunkId chunk, std::span<const std::uint64_t> vertices,
                        std::vector<TriangleAt>& out) const;

  const ChunkStore& store_;
  const Partition& partition_;
  double reach_;
  bool with_values_;
  std::vector<Triangle64> removed_;
  VertexFilter removed_at_;
  std::unique_ptr<Cache> cache_;
};

}  // namespace orbweave
