#include "engine/ball_pivoting/ball_pivoting.h"

namespace orbweave {

double halo_width(std::span<const double> ball_radii) {
  double width = 6.0 * ball_radii.front();
  for (const double ball_radius : ball_radii.subspan(1)) width += 4.0 * ball_radius;
  return width;
}

}  // namespace orbweave
