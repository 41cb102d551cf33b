#include "engine/holes/smooth_disc.h"

#include <cmath>
#include <span>

#include "engine/holes/direct_fill.h"

namespace orbweave {
namespace {

double area_of(const PatchMesh& disc) {
  double area = 0.0;
  for (const CornerTriangle& t : disc.triangles()) {
    const Vec3 a = disc.positions()[t[0]];
    area += 0.5 * norm(cross(disc.positions()[t[1]] - a, disc.positions()[t[2]] - a));
  }
  return area;
}

/// Whether a patch of this area at the rim's spacing has about as many points as allowed.
bool fits(double area, double spacing, const PatchOptions& options) {
  const double points = area / (std::sqrt(0.75) * spacing * spacing);
  return points <= 1.5 * options.max_new_points + 16.0;
}

}  // namespace

std::string too_many_points(const PatchOptions& options) {
  return "needs more than " + std::to_string(options.max_new_points) + " new points";
}

std::optional<PatchMesh> smooth_disc(const HoleProblem& problem, const Rim& rim, int order,
                                     const PatchOptions& options) {
  constexpr int kRounds = 5;
  PatchMesh disc = disc_of_loop(problem, rim);
  if (!fits(area_of(disc), rim.spacing, options)) return std::nullopt;
  for (int round = 0; round < kRounds; ++round) {
    const std::uint32_t before = disc.size() - disc.corners();
    if (before > options.max_new_points) return std::nullopt;
    const std::uint32_t added =
        disc.split_long_edges(kLongestEdge * rim.spacing, options.max_new_points + 1 - before);
    if (round > 1 && added == 0) break;
    disc.flip_to_delaunay();
    // Triangles between corners far apart say little about where a plate would bend; a membrane
    // evens them out first.
    const bool is_plate = order == 2 && round > 0;
    disc.smooth(is_plate ? 2 : 1, is_plate ? rim.across : std::span<const Vec3>{});
    disc.collapse_short_edges(kShortestEdge * rim.spacing);
    disc.flip_to_delaunay();
  }
  if (disc.size() - disc.corners() > options.max_new_points) return std::nullopt;
  return disc;
}

}  // namespace orbweave
