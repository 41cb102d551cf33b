#include "io/ball_radii.h"

#include <cmath>

namespace orbweave {

std::optional<RadiiObjection> objection_to_radii(std::span<const double> ball_radii) {
  if (ball_radii.empty()) return RadiiObjection{"at least one ball radius is needed", "a number"};
  double last = 0.0, sum = 0.0;
  for (const double ball_radius : ball_radii) {
    if (!(ball_radius > last) || !std::isfinite(ball_radius))
      return RadiiObjection{"ball radii must be positive and ascending",
                            "positive numbers in ascending order"};
    last = ball_radius;
    sum += ball_radius / ball_radii.front();
  }
  if (ball_radii.front() < kLeastBallRadius || last > kMostBallRadius)
    return RadiiObjection{"a ball radius cannot be computed with", "radii from 1e-75 to 1e75"};
  if (last > kMostRadiiRatio * ball_radii.front())
    return RadiiObjection{"the largest ball radius is more than 65536 times the smallest",
                          "radii that differ by a factor of at most 65536"};
  if (sum > kMostRadiiSum)
    return RadiiObjection{"the ball radii together are more than 131072 times the smallest",
                          "fewer or smaller radii"};
  return std::nullopt;
}

}  // namespace orbweave
