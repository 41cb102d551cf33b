#include "engine/ball_pivoting/halo_width.h"

#include <algorithm>

#include "engine/ball_pivoting/perturbation.h"

namespace orbweave {

double halo_width(std::span<const double> ball_radii) {
  double width = 6.0 * ball_radii.front();
  for (const double ball_radius : ball_radii.subspan(1)) {
    width = std::max(6.0 * ball_radius, 4.0 * ball_radius + width);
  }
  // Whether a triangle stands alone is seen one triangle further; and the fans of its vertices are
  // to be right as well, not just those of the owned one.
  width += 4.0 * ball_radii.back();
  // Room for the perturbation of both ends of every step.
  return width * (1.0 + 16.0 * kPerturbation);
}

}  // namespace orbweave
