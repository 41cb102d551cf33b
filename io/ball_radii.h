// Which ball radii can be computed with.
#pragma once

#include <optional>
#include <span>
#include <string>

namespace orbweave {

/// Squares of squares of lengths outside of this range are no numbers.
inline constexpr double kLeastBallRadius = 1e-75;
inline constexpr double kMostBallRadius = 1e75;
/// Largest quotient of two ball radii of a job.
inline constexpr double kMostRadiiRatio = 65536.0;
/// Largest sum of the ball radii, in smallest ones. With the ratio this bounds the halo to
/// 4 * 131072 + 6 * 65536 smallest radii (docs/dev/halo.md), less than the cells of the neighbour
/// search have room for.
inline constexpr double kMostRadiiSum = 131072.0;

struct RadiiObjection {
  std::string problem;   ///< "ball radii must be positive and ascending"
  std::string expected;  ///< what would do
};

/// Why ball pivoting cannot work with these radii; nothing where it can.
std::optional<RadiiObjection> objection_to_radii(std::span<const double> ball_radii);

}  // namespace orbweave
