// The octree of chunks, cut from the count grid.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/box.h"
#include "io/store/chunk_store.h"
#include "partition/canonical_order.h"
#include "partition/point_counts.h"
#include "partition/root_cube.h"

namespace orbweave {

/// A leaf of the octree: the unit of storage and work.
struct Chunk {
  std::uint64_t code_begin = 0;  ///< first fine Morton code that belongs to it
  std::uint64_t code_end = 0;    ///< one past the last
  int depth = 0;
  Box box;                   ///< the leaf's cube (closed box; ownership is by code)
  std::uint64_t points = 0;  ///< as counted, duplicates included
};

/// Non-empty leaves in Morton order; codes of different leaves do not overlap.
class Octree {
 public:
  Octree() = default;
  Octree(RootCube root, std::vector<Chunk> chunks);
  const RootCube& root() const { return root_; }
  const std::vector<Chunk>& chunks() const { return chunks_; }
  /// Of all chunks, as counted.
  std::uint64_t points() const;
  /// The chunk that owns a point. Precondition: some chunk does (throws Error bad input if the
  /// cloud changed between the passes).
  ChunkId chunk_of(Vec3 p) const;
  ChunkId chunk_of_code(std::uint64_t code) const;
  const MortonFrame& frame() const { return frame_; }
  /// Chunks, `self` excluded, whose cube comes within `halo_width` of the cube of `self` along
  /// every axis, ascending. O(neighbours * depth).
  std::vector<ChunkId> neighbors(ChunkId self, double halo_width) const;

 private:
  struct Node;
  void collect(const Node& node, const Box& reach, ChunkId self, std::vector<ChunkId>& out) const;

  RootCube root_;
  MortonFrame frame_;
  std::vector<Chunk> chunks_;
  std::vector<std::uint64_t> begins_;
  /// first_[k]: first chunk that ends after the k-th of the equal code ranges of 2^shift_ codes
  /// begins; narrows the search of chunk_of_code.
  std::vector<ChunkId> first_;
  int shift_ = 0;
};

/// Splits every node that holds more than `chunk_points` points, as far as the count grid
/// resolves.
Octree cut_octree(const PointCounts& grid, const RootCube& root, std::uint64_t chunk_points);

/// The same points in more chunks: splits the chunks numbered `dense` (ascending) that hold more
/// than `chunk_points` points, as far as `grid` resolves, which counts their points and no others.
Octree refined(const Octree& octree, std::span<const ChunkId> dense, const PointCounts& grid,
               std::uint64_t chunk_points);

/// The same points in fewer chunks: siblings are put together as long as they hold at most
/// `chunk_points` points. Every chunk of `octree` lies in one of the result's.
Octree coarsened(const Octree& octree, std::uint64_t chunk_points);

}  // namespace orbweave
