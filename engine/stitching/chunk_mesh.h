// A chunk's part of the mesh: its own triangles, and what the other chunks need to know of its
// seams. Stitching is by ownership: a seam triangle is computed alike
// by all chunks that see it and kept by the one that owns its first vertex in canonical order.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/holes/problem/boundary_loop.h"
#include "io/box.h"
#include "io/mesh_facts.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// A vertex as a place where triangles hang together: the vertex itself or, where several fans
/// meet, one of its fans (named by its smallest first neighbour).
struct SeamNode {
  static constexpr std::uint64_t kWhole = ~std::uint64_t{0};
  std::uint64_t vertex = 0;     ///< global number
  std::uint64_t fan = kWhole;   ///< global number, or kWhole
  std::uint64_t component = 0;  ///< of the chunk's components
  friend auto operator<=>(const SeamNode&, const SeamNode&) = default;
};

/// A connected piece of the mesh, or the part of one that a chunk owns.
struct ChunkPiece {
  std::uint64_t triangles = 0;
  Triangle64 first{};  ///< the smallest of them; meaningless where there is none
  Box box;             ///< of their vertices
};

/// What a chunk contributes. Vertex numbers are ranks in the canonical order of the whole cloud,
/// but for those of `triangles`, which are the chunk's own (local_numbers.h).
struct ChunkMesh {
  std::vector<Triangle> triangles;            ///< owned, smallest first, sorted, as the mesh has it
  std::vector<std::uint8_t> fans;             ///< per owned point: number of fans, 0 when unused
  std::vector<std::uint64_t> outer_vertices;  ///< vertices of `triangles` that others own, sorted
  std::vector<Vec3> outer_positions;          ///< theirs
  std::vector<OpenFan> boundary;              ///< at owned vertices; components are the chunk's
  std::vector<BoundaryVertex> boundary_vertices;  ///< those of `boundary`, ascending
  std::vector<SeamNode> seam;                     ///< nodes that other chunks may share, sorted
  std::vector<ChunkPiece> pieces;                 ///< the chunk's components
  std::uint64_t conflicts_lost = 0;
  std::uint64_t isolated_dropped = 0;
  double area = 0.0;    ///< of `triangles`
  double volume = 0.0;  ///< of the cones from ChunkPoints::origin to them; positive: faces outward
  /// Of methods that tell: 1 per owned point that is sampled too sparsely; else empty.
  std::vector<std::uint8_t> undersampled;
  VoronoiFacts voronoi;  ///< likewise
  SideFacts sides;       ///< where the normals are looked at
};

/// The points that a chunk was reconstructed from, in canonical order.
struct ChunkPoints {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;
  std::vector<std::uint64_t> global;  ///< global numbers, ascending
  std::vector<std::uint8_t> owned;
  std::uint32_t owned_begin = 0;  ///< owned points are contiguous
  std::uint32_t owned_end = 0;
  Vec3 origin;  ///< that volumes are counted from: the same for all chunks

  bool is_owned(std::uint32_t point) const { return point >= owned_begin && point < owned_end; }
};

/// `seam_width`: no triangle has an edge longer than that. `box`: the chunk's cube.
/// `stop` is looked at between its passes over points and triangles.
ChunkMesh make_chunk_mesh(const ChunkPoints& points, BallPivotingResult result, const Box& box,
                          double seam_width, const StopToken* stop = nullptr);

}  // namespace orbweave
