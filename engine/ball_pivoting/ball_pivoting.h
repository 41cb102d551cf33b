// Order-free ball pivoting: the set of all triangles with an empty ball, without a front.
// Bernardini, Mittleman, Rushmeier, Silva, Taubin: The Ball-Pivoting Algorithm for Surface
// Reconstruction, 1999; docs/ball-pivoting.md for the order-free form.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/walk.h"
#include "io/box.h"
#include "io/triangle_mesh.h"

namespace orbweave {

struct BallPivotingOptions {
  /// Ball radii in ascending order, world units; at least one, all positive and finite.
  std::vector<double> ball_radii;
  /// Origin that positions are taken relative to, the same for all chunks of a cloud, so that
  /// UTM-sized coordinates lose nothing.
  Vec3 origin;
  /// Lanes of the walk; every width decides alike, the widest the machine has is the fastest.
  VectorWidth width = widest_supported();
};

/// A fan with a gap: the boundary runs previous -> vertex -> next along its triangles' edges.
struct BoundaryFan {
  std::uint32_t previous = 0;
  std::uint32_t vertex = 0;
  std::uint32_t next = 0;
  friend auto operator<=>(const BoundaryFan&, const BoundaryFan&) = default;
};

/// Which fan the triangle (vertex, first, ...) belongs to, at a vertex with several.
struct FanMember {
  std::uint32_t vertex = 0;
  std::uint32_t first = 0;
  std::uint32_t fan = 0;  ///< smallest first neighbour of the fan
  friend auto operator<=>(const FanMember&, const FanMember&) = default;
};

struct BallPivotingResult {
  /// Triangles whose smallest vertex is flagged as owned, each with its smallest vertex first,
  /// sorted. Indices into the input.
  std::vector<Triangle> triangles;
  /// Number of fans at each input point (0: no triangle uses it; above 1: not manifold there).
  /// This and the two lists are those of the uncut cloud at every vertex of `triangles`.
  std::vector<std::uint8_t> fans;
  std::vector<BoundaryFan> boundary;   ///< fans with a gap, vertices ascending
  std::vector<FanMember> fan_members;  ///< at vertices with several fans, sorted
  std::uint64_t conflicts_lost = 0;    ///< triangles that lost against a rival on an edge (owned)
  std::uint64_t isolated_dropped = 0;  ///< triangles that shared no edge with another (owned)
};

/// Margin that a chunk needs around its owned points for their triangles to be those of the
/// uncut cloud. docs/halo.md derives it.
double halo_width(std::span<const double> ball_radii);

/// Reconstructs `positions` with unit or non-unit `normals` (zero-free), both n long.
/// `owned[i]` != 0 marks points whose triangles are wanted; empty: all. Positions must be
/// distinct and in canonical order. Runs on the calling TBB arena; the result does not depend
/// on the number of threads. Complexity O(n) for a bounded number of points per ball.
/// Throws Error (usage) for bad radii.
BallPivotingResult ball_pivoting(std::span<const Vec3> positions, std::span<const Vec3> normals,
                                 std::span<const std::uint8_t> owned,
                                 const BallPivotingOptions& options);

}  // namespace orbweave
