#include "engine/ball_pivoting/ball_pivoting.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "engine/ball_pivoting/cell_grid.h"
#include "engine/ball_pivoting/fan_table.h"
#include "engine/ball_pivoting/perturbation.h"
#include "engine/ball_pivoting/surface_state.h"
#include "io/error.h"

namespace orbweave {
namespace {

/// Cells are wider than two radii by more than rounding, so that neighbours are never two apart.
constexpr double kCellMargin = 1.0 + 1e-9;

void check_radii(std::span<const double> ball_radii) {
  double last = 0.0;
  for (const double ball_radius : ball_radii) {
    if (!(ball_radius > last) || !std::isfinite(ball_radius)) {
      throw_usage("ball radii must be positive and ascending");
    }
    last = ball_radius;
  }
  if (ball_radii.empty()) throw_usage("at least one ball radius is needed");
}

/// Positions relative to the origin, in general position.
std::vector<Vec3> general_position(std::span<const Vec3> positions, Vec3 origin, double scale) {
  std::vector<Vec3> local(positions.size());
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, positions.size(), 4096), [&](const Range& r) {
    for (std::size_t i = r.begin(); i < r.end(); ++i) {
      local[i] = (positions[i] - origin) + perturbation(positions[i], scale);
    }
  });
  return local;
}

}  // namespace

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

BallPivotingResult ball_pivoting(std::span<const Vec3> positions, std::span<const Vec3> normals,
                                 std::span<const std::uint8_t> owned,
                                 const BallPivotingOptions& options) {
  check_radii(options.ball_radii);
  const double smallest_radius = options.ball_radii.front();
  const std::vector<Vec3> local =
      general_position(positions, options.origin, kPerturbation * smallest_radius);
  SurfaceState state({local, normals}, owned);
  for (std::size_t level = 0; level < options.ball_radii.size(); ++level) {
    const double ball_radius = options.ball_radii[level];
    const CellGrid grid(local, normals, 2.0 * ball_radius * kCellMargin);
    if (level == 0) {
      state.take_first_level(walk_all(grid, ball_radius, {}, options.width));
    } else {
      state.take_level(walk_all(grid, ball_radius, state.open(), options.width));
    }
    if (!state.any_open()) break;
  }
  state.drop_isolated();
  BallPivotingResult result;
  result.isolated_dropped = state.isolated_dropped();
  result.conflicts_lost = state.conflicts_lost();
  result.triangles = state.take_triangles();
  state.describe(result.boundary, result.fan_members);
  result.fans = state.take_fan_counts();
  return result;
}

}  // namespace orbweave
