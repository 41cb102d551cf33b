#include "engine/holes/smooth_disc.h"

#include <cmath>
#include <limits>
#include <span>

#include "engine/holes/bending_energy.h"
#include "engine/holes/direct_fill.h"

namespace orbweave {
namespace {

/// Energy of a round relative to the one before from which on no other is worthwhile.
constexpr double kLeastGain = 0.97;

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

/// One round: edges split to the rim's spacing, then at rest. False where too many points would be
/// needed.
bool refine(const Rim& rim, const RimSheet& sheet, bool is_plate, const PatchOptions& options,
            PatchMesh& disc) {
  const std::uint32_t before = disc.size() - disc.corners();
  if (before > options.max_new_points) return false;
  disc.split_long_edges(kLongestEdge * rim.spacing, options.max_new_points + 1 - before);
  if (disc.size() - disc.corners() > options.max_new_points) return false;
  disc.flip_to_delaunay();
  disc.smooth(is_plate ? 2 : 1, is_plate ? sheet : RimSheet{});
  disc.collapse_short_edges(kShortestEdge * rim.spacing);
  disc.flip_to_delaunay();
  return true;
}

}  // namespace

std::string too_many_points(const PatchOptions& options) {
  return "needs more than " + std::to_string(options.max_new_points) + " new points";
}

std::optional<PatchMesh> smooth_disc(const HoleProblem& problem, const Rim& rim, int order,
                                     const PatchOptions& options) {
  constexpr int kRounds = 6;
  PatchMesh disc = disc_of_loop(problem, rim);
  const RimSheet sheet = order == 2 ? sheet_at_rim(problem, rim) : RimSheet{};
  if (!fits(area_of(disc), rim.spacing, options)) return std::nullopt;
  std::optional<PatchMesh> best;
  double least_energy = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    const bool is_plate = order == 2 && round > 0;
    if (!refine(rim, sheet, is_plate, options, disc)) return best;
    if (order == 2 && round == 0) continue;
    // A plate that has grown is another plate: its triangles, by which it is measured, have too.
    // On a ragged rim that need not come to an end.
    const double energy = bending_energy(problem, patch_of_disc(problem, rim, disc));
    if (!(energy < kLeastGain * least_energy)) break;
    least_energy = energy;
    best = disc;
  }
  return best;
}

}  // namespace orbweave
