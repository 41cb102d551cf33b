// Facts of the whole mesh from the facts of its chunks, in memory proportional to seams and
// boundaries.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/stitching/chunk_mesh.h"
#include "io/report.h"

namespace orbweave {

class MeshSummary {
 public:
  /// Adds a chunk; its triangles and positions may be left empty when `triangles` says how many
  /// there were.
  void add(const ChunkMesh& chunk, std::uint64_t triangles);
  /// Counts of the stitched mesh (area included; bounds and checksum are the exporter's).
  MeshFacts facts();
  std::uint64_t conflicts_lost() const { return conflicts_lost_; }
  std::uint64_t unused_points() const { return unused_points_; }

 private:
  std::uint64_t count_components();
  std::uint64_t count_loops();

  MeshFacts facts_;
  std::vector<SeamNode> seam_;
  std::vector<Triangle64> boundary_;
  std::uint64_t components_ = 0;
  std::uint64_t conflicts_lost_ = 0;
  std::uint64_t unused_points_ = 0;
};

}  // namespace orbweave
