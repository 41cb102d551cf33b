// Fewer points: a subset in which no two are closer than a spacing and every point left out is
// close to one that was kept, found without regard to the order of points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

struct ThinningOptions {
  double spacing = 0.0;  ///< world units, positive
  /// Points whose normals differ by more than the angle of this cosine lie on different sheets and
  /// do not replace one another; not used without normals. -1: never.
  double min_cosine = 0.0;
  const StopToken* stop = nullptr;  ///< looked at every few thousand points; may be null
};

/// Margin that a chunk needs around its points.
double thinning_halo(const ThinningOptions& options);

/// 1 for each of positions [begin, end) that is kept: any two kept points are at least the spacing
/// apart (or on different sheets), and each point left out is closer than that to a kept one. What
/// comes first follows from the cell of a lattice that a point lies in and the bits of its
/// coordinates, such that the halo is finite (docs/cleaning.md). `normals` may be empty, else of
/// any length; a point whose normal is zero is on a sheet of its own. Positions must be distinct
/// and finite and reach as far as the halo; the result then depends neither on their order nor on
/// what else they hold. Points whose state is 1 are kept whatever lies near them and come before
/// all others, those whose state is 2 are left out and replace none; empty: all are 0, to be
/// decided. Runs on the calling TBB arena. O(n log n).
std::vector<std::uint8_t> thin_points(std::span<const Vec3> positions,
                                      std::span<const Vec3> normals, std::uint32_t begin,
                                      std::uint32_t end, const ThinningOptions& options,
                                      std::span<const std::uint8_t> states = {});

/// Merging: the points kept at `spacing` = tolerance, each moved to the mean of the points that are
/// closer to it than to any other kept one. `normals` (may be empty) are averaged likewise and
/// normalised.
struct MergedPoints {
  std::vector<std::uint8_t> kept;  ///< of points [begin, end)
  std::vector<Vec3> positions;     ///< of points [begin, end); of the kept ones the new position
  std::vector<Vec3> normals;       ///< likewise; empty without normals
};
double merging_halo(const ThinningOptions& options);
MergedPoints merge_points(std::span<const Vec3> positions, std::span<const Vec3> normals,
                          std::uint32_t begin, std::uint32_t end, const ThinningOptions& options);

}  // namespace orbweave
