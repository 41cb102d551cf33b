#include "engine/ball_pivoting/halo_width.h"

#include <algorithm>
#include <cstddef>

#include "engine/ball_pivoting/perturbation.h"

namespace orbweave {
namespace {

/// Room for the perturbation of both ends of every step.
constexpr double kRoom = 1.0 + 16.0 * kPerturbation;

}  // namespace

double halo_width(std::span<const double> ball_radii) {
  double width = 6.0 * ball_radii.front();
  for (const double ball_radius : ball_radii.subspan(1)) {
    width = std::max(6.0 * ball_radius, 4.0 * ball_radius + width);
  }
  // Whether a triangle stands alone is seen one triangle further; and the fans of its vertices are
  // to be right as well, not just those of the owned one.
  width += 4.0 * ball_radii.back();
  return width * kRoom;
}

double longest_edge(std::span<const double> ball_radii) { return 2.0 * ball_radii.back() * kRoom; }

std::vector<double> walk_reaches(std::span<const double> ball_radii) {
  std::vector<double> reaches(ball_radii.size());
  // The fans of the vertices of triangles that may support an owned one.
  double reach = 4.0 * ball_radii.back();
  for (std::size_t level = ball_radii.size(); level-- > 0;) {
    // The rivals of a triangle that counts, and what was there before.
    reach += 4.0 * ball_radii[level];
    reaches[level] = reach * kRoom;
  }
  return reaches;
}

}  // namespace orbweave
