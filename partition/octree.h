// The octree of chunks, cut from the count grid.
#pragma once

#include <cstdint>
#include <vector>

#include "io/box.h"
#include "io/chunk_store.h"
#include "partition/count_grid.h"
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
  /// The chunk that owns a point. Precondition: some chunk does (throws Error bad input if the
  /// cloud changed between the passes).
  ChunkId chunk_of(Vec3 p) const;
  ChunkId chunk_of_code(std::uint64_t code) const;
  /// Chunks, `self` excluded, whose cube comes within `halo_width` of the cube of `self`.
  std::vector<ChunkId> neighbors(ChunkId self, double halo_width) const;

 private:
  RootCube root_;
  std::vector<Chunk> chunks_;
  std::vector<std::uint64_t> begins_;
};

/// Splits every node that holds more than `chunk_points` points, as far as the count grid
/// resolves.
Octree cut_octree(const CountGrid& grid, const RootCube& root, std::uint64_t chunk_points);

}  // namespace orbweave
