// One tile: a chunk's triangles, the patches of the holes that begin in it, and their vertices.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/pipeline/output/tile_input.h"

namespace orbweave {

/// Rows of a tile's triangles that follow each other in the one mesh, too. Stored as it is.
struct TriangleRun {
  std::uint64_t row = 0;    ///< in the tile
  std::uint64_t first = 0;  ///< in the one mesh
  std::uint64_t rows = 0;
};

/// Triangles of a batch of patches that go to one tile.
struct PatchRun {
  ChunkId chunk = 0;
  ChunkId batch = 0;
  std::uint64_t first = 0;
  std::uint64_t rows = 0;
};

/// All patches: each goes to the chunk that owns the first vertex of its hole's rim. By chunk, then
/// in the order of the mesh.
std::vector<PatchRun> patch_runs(const ChunkStore& store, const TileInput& input);

/// Where chunks' triangles and batches of patches begin in the one mesh.
struct FirstRows {
  std::vector<std::uint64_t> of_chunk;
  std::vector<std::uint64_t> of_batch;
};
FirstRows first_rows(const TileInput& input);

class Tile {
 public:
  /// Reads the triangles and numbers their vertices.
  Tile(const ChunkStore& store, const TileInput& input, ChunkId chunk,
       std::span<const PatchRun> patches, const FirstRows& first_rows);

  std::uint64_t vertices() const { return own_.count() + outer_.size(); }
  std::uint64_t triangles() const { return triangles_.size(); }
  const std::vector<TriangleRun>& runs() const { return runs_; }
  MeshHeader header() const;
  /// Writes everything; `bounds` gets those of the vertices.
  void write(MeshWriter& writer, Box& bounds);

 private:
  /// A vertex that is no point of the chunk under its own number.
  struct Outer {
    std::uint64_t id = 0;      ///< in the one mesh
    std::uint64_t source = 0;  ///< the point, or kNewVertex + index over all batches
    friend auto operator<=>(const Outer&, const Outer&) = default;
  };

  void load_scanned();
  void load_patches(std::span<const PatchRun> patches, const FirstRows& first_rows);
  void add_run(std::uint64_t first, std::uint64_t rows);
  void find_vertices();
  bool is_own(std::uint64_t source, std::uint64_t id) const;
  Triangle64 in_tile_numbers(const Triangle64& t);
  void write_own(MeshWriter& writer, Box& bounds);
  void write_outer(MeshWriter& writer, std::span<const Outer> vertices, Box& bounds) const;
  std::size_t append_points(std::span<const Outer> vertices, PointCloud& cloud) const;
  std::size_t append_new(std::span<const Outer> vertices, PointCloud& cloud) const;
  void write_batch(MeshWriter& writer, PointCloud& cloud, std::span<const std::uint64_t> ids,
                   Box& bounds) const;

  const ChunkStore& store_;
  const TileInput& input_;
  ChunkId chunk_;
  std::uint64_t first_;   // of the chunk's points
  std::uint64_t points_;  // of the chunk
  std::vector<Triangle64> triangles_;
  std::vector<std::int32_t> hole_;
  std::vector<TriangleRun> runs_;
  VertexRanks ranks_;
  RankedPoints own_;          // the chunk's points that the tile uses
  std::vector<Outer> outer_;  // by number
  std::size_t outer_below_ = 0;
};

}  // namespace orbweave
