// Order-free ball pivoting: the set of all triangles with an empty ball, without a front.
// Bernardini, Mittleman, Rushmeier, Silva, Taubin: The Ball-Pivoting Algorithm for Surface
// Reconstruction, 1999; docs/dev/ball-pivoting.md for the order-free form.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/halo_width.h"
#include "engine/ball_pivoting/pivoting_result.h"
#include "engine/ball_pivoting/walk.h"
#include "io/box.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"

namespace orbweave {

struct BallPivotingOptions {
  /// Ball radii in ascending order, world units; at least one, all such that
  /// objection_to_radii() has none (io/ball_radii.h).
  std::vector<double> ball_radii;
  /// Lanes of the walk; every width decides alike, the widest the machine has is the fastest.
  VectorWidth width = widest_supported();
  const StopToken* stop = nullptr;  ///< looked at every few thousand points; may be null
};

/// Reconstructs `positions` with unit or non-unit `normals` (zero-free), both n long.
/// `owned[i]` != 0 marks points whose triangles are wanted; empty: all. Positions must be
/// distinct and in canonical order, at any distance from each other and from zero: points that are
/// many thousands of radii apart are worked on in several parts. Runs on the calling TBB arena; the
/// result does not depend on the number of threads. Complexity O(n) for a bounded number of points
/// per ball. Of no points there is an empty result. Throws Error (usage) for bad radii.
BallPivotingResult ball_pivoting(std::span<const Vec3> positions, std::span<const Vec3> normals,
                                 std::span<const std::uint8_t> owned,
                                 const BallPivotingOptions& options);

}  // namespace orbweave
