// Which triangles of a Super Cocone all chunks concerned have.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/surface/stored_cells.h"
#include "engine/stitching/chunk_mesh.h"

namespace orbweave {

/// The triangles of one chunk that stay, and what stands around them.
struct AgreedTriangles {
  /// With a vertex of the chunk, and all others at the vertices of these: sorted.
  std::vector<Triangle64> all;
  std::uint64_t contested = 0;  ///< counted by the first chunk that has the triangle
  std::uint64_t seam = 0;       ///< across chunks, counted by the owner of the first vertex
};

/// Reads the chunks' cells as far as they are asked for. All arguments have to outlive the object.
class SeamAgreement {
 public:
  /// `longest`: a triangle across chunks with a longer edge is contested by all.
  SeamAgreement(const ChunkStore& store, const Partition& partition, double longest)
      : store_(store), partition_(partition), longest_(longest) {}

  AgreedTriangles of(ChunkId chunk, const ChunkCells& cells);

  /// All own points of a chunk, and the vertices of the triangles that others own, in canonical
  /// order.
  ChunkPoints points_of(ChunkId chunk, const std::vector<Triangle64>& triangles) const;

 private:
  /// Positions of vertices, read chunk by chunk.
  struct Places {
    std::vector<std::uint64_t> vertices;  ///< ascending
    std::vector<Vec3> positions, normals;

    Vec3 of(std::uint64_t vertex) const;
  };

  Places places_of(std::vector<std::uint64_t> vertices) const;
  const std::vector<Triangle64>& seam_of(ChunkId chunk);
  std::vector<ChunkId> chunks_of(const Triangle64& triangle) const;
  bool all_have(const Triangle64& triangle, const Places& places);
  bool is_owned(std::uint64_t vertex, ChunkId chunk) const {
    return vertex >= partition_.first_vertex[chunk] && vertex < partition_.first_vertex[chunk + 1];
  }
  void add_around(ChunkId chunk, std::vector<Triangle64>& triangles);

  const ChunkStore& store_;
  const Partition& partition_;
  double longest_;
  std::map<ChunkId, std::vector<Triangle64>> seams_;
};

}  // namespace orbweave
