// Facts of the whole mesh from the facts of its chunks, in memory proportional to seams and
// boundaries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "engine/geometry/disjoint_sets.h"
#include "engine/stitching/chunk_mesh.h"
#include "io/mesh_facts.h"

namespace orbweave {

/// The boundary of the stitched mesh and what it bounds.
struct StitchedBoundary {
  std::vector<OpenFan> fans;             ///< components are indices of `pieces`
  std::vector<BoundaryVertex> vertices;  ///< ascending
  std::vector<ChunkPiece> pieces;        ///< connected pieces of the whole mesh
  std::vector<std::uint64_t> pinched;    ///< vertices with several fans, ascending
};

/// Number of boundary loops, as mesh_facts counts them (engine/validation/boundary_loops.h).
std::uint64_t count_loops(std::span<const OpenFan> fans);

/// Brings the counts that follow from others up to date: Euler characteristic, watertight.
void derive_facts(MeshFacts& facts);

class MeshSummary {
 public:
  /// The last chunk, in canonical order, whose triangles may use a vertex.
  struct Users {
    std::uint64_t last = 0;  ///< number of the chunk
    std::uint64_t end = 0;   ///< all vertices from the one asked for to before this have that chunk
  };
  using LastUse = std::function<Users(std::uint64_t vertex)>;

  /// Positions and normals of boundary vertices are kept where holes are to be looked at. Seams
  /// are forgotten once they are complete, where `last_use` says when that is; else at the end.
  explicit MeshSummary(bool keeps_vertices = true, LastUse last_use = {})
      : keeps_vertices_(keeps_vertices), last_use_(std::move(last_use)) {}
  /// Makes room for all that the chunks will have, so that nothing is copied when it grows.
  void reserve(std::uint64_t fans, std::uint64_t vertices, std::uint64_t pieces);
  /// Adds a chunk, in canonical order; its triangles and outer vertices may be left empty when
  /// `triangles` says how many there were. `first_vertex`: global number of its first point.
  void add(const ChunkMesh& chunk, std::uint64_t first_vertex, std::uint64_t triangles);
  /// After the last chunk: counts of the stitched mesh (area included; bounds and checksum are the
  /// exporter's).
  void finish();

  const MeshFacts& facts() const { return facts_; }
  const StitchedBoundary& boundary() const { return boundary_; }
  /// Gives the boundary away.
  StitchedBoundary take_boundary() { return std::move(boundary_); }
  std::uint64_t conflicts_lost() const { return conflicts_lost_; }
  std::uint64_t unused_points() const { return unused_points_; }
  const VoronoiFacts& voronoi() const { return voronoi_; }
  const SideFacts& sides() const { return sides_; }

 private:
  void count_fans(std::span<const std::uint8_t> fans, std::uint64_t first_vertex);
  void sort_seam();
  void settle_seams();
  void join_pieces();

  MeshFacts facts_;
  bool keeps_vertices_;
  LastUse last_use_;
  StitchedBoundary boundary_;
  std::vector<SeamNode> seam_;           // of the chunks, until the last has come
  std::vector<std::size_t> runs_ = {0};  // where sorted runs of seam_ begin, and where it ends
  std::size_t settle_at_ = 0;            ///< nodes
  std::uint64_t chunks_ = 0;
  DisjointSets sets_{0};  ///< of pieces
  std::uint64_t conflicts_lost_ = 0;
  std::uint64_t unused_points_ = 0;
  VoronoiFacts voronoi_;
  SideFacts sides_;
};

}  // namespace orbweave
