#include "engine/ball_pivoting/ball_pivoting.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/cell_grid.h"
#include "engine/ball_pivoting/fan_table.h"
#include "engine/ball_pivoting/general_position.h"
#include "engine/ball_pivoting/halo_width.h"
#include "engine/ball_pivoting/parts.h"
#include "engine/ball_pivoting/perturbation.h"
#include "engine/ball_pivoting/surface_state.h"
#include "io/ball_radii.h"
#include "io/error.h"

namespace orbweave {
namespace {

void check_radii(std::span<const double> ball_radii) {
  if (const auto objection = objection_to_radii(ball_radii))
    throw_usage(objection->problem,
                {.file = {}, .place = {}, .found = {}, .expected = objection->expected});
}

/// Extent up to which points can be worked on at once: their coordinates are exact, and the cells
/// of the smallest radius, which are the most, have numbers. At least two halos, so that the
/// points around any one can be.
double largest_extent_at_once(std::span<const double> ball_radii) {
  return std::min(largest_exact_extent(lattice_step(ball_radii)),
                  largest_extent_in_cells(ball_radii.front()));
}

/// The points that a level has to walk at: of the unfinished ones those within reach of the owned
/// ones. Nothing that is farther away changes a triangle of theirs.
class PointsInReach {
 public:
  explicit PointsInReach(const PivotInput& input) : positions_(input.positions) {
    for (std::size_t i = 0; i < input.owned.size(); ++i)
      if (input.owned[i] != 0) owned_.extend(positions_[i]);
  }
  std::vector<std::uint8_t> of(std::span<const std::uint8_t> unfinished, double reach) const {
    std::vector<std::uint8_t> near(unfinished.begin(), unfinished.end());
    if (owned_.empty()) return near;
    const Box box = owned_.grown(reach);
    for (std::size_t i = 0; i < near.size(); ++i)
      if (near[i] != 0 && !box.contains(positions_[i])) near[i] = 0;
    return near;
  }

 private:
  std::span<const Vec3> positions_;
  Box owned_;
};

/// All points at once. `box`: the bounds of the positions.
BallPivotingResult pivot_whole(const PivotInput& input, const BallPivotingOptions& options,
                               const Box& box) {
  const double step = lattice_step(options.ball_radii);
  const Vec3 origin = on_lattice(box.center(), step);
  const std::vector<Vec3> local = general_position(input.positions, origin, step);
  SurfaceState state({local, input.normals}, input.owned, options.stop);
  const PointsInReach points_in_reach(input);
  const std::vector<double> reaches = walk_reaches(options.ball_radii);
  for (std::size_t level = 0; level < options.ball_radii.size(); ++level) {
    const double ball_radius = options.ball_radii[level];
    check_stop(options.stop);
    const CellGrid grid(local, input.normals, CellSpace(ball_radius, step, origin));
    if (level == 0) {
      state.take_first_level(walk_all(grid, ball_radius, {}, options.width, options.stop));
    } else {
      state.take_level(walk_all(grid, ball_radius,
                                points_in_reach.of(state.unfinished(), reaches[level]),
                                options.width, options.stop, state.open_corners()));
    }
    if (!state.any_unfinished()) break;
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

}  // namespace

BallPivotingResult ball_pivoting(std::span<const Vec3> positions, std::span<const Vec3> normals,
                                 std::span<const std::uint8_t> owned,
                                 const BallPivotingOptions& options) {
  check_radii(options.ball_radii);
  if (positions.empty()) return {};
  return pivot_in_parts(
      {positions, normals, owned}, halo_width(options.ball_radii),
      largest_extent_at_once(options.ball_radii),
      [&](const PivotInput& part, const Box& box) { return pivot_whole(part, options, box); },
      options.stop);
}

}  // namespace orbweave
