#include "engine/holes/patch/smooth_disc.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/holes/rbf/bending_energy.h"

namespace orbweave {
namespace {

/// Of a graded disc, about.
constexpr double kMostPoints = 50'000.0;

double area_of(const PatchMesh& disc) {
  double area = 0.0;
  for (const CornerTriangle& t : disc.triangles()) {
    const Vec3 a = disc.positions()[t[0]];
    area += 0.5 * norm(cross(disc.positions()[t[1]] - a, disc.positions()[t[2]] - a));
  }
  return area;
}

/// About how many points a patch takes that starts with this disc.
double expected_points(const PatchMesh& disc, double spacing) {
  return area_of(disc) / (std::sqrt(0.75) * spacing * spacing);
}

/// Edges of a patch for which this many points are expected: the rim's. A larger disc gets larger
/// triangles, not more: nothing is known of its middle.
double patch_spacing(const Rim& rim, double points, const PatchOptions& options) {
  return options.graded ? rim.spacing * std::sqrt(std::max(1.0, points / kMostPoints))
                        : rim.spacing;
}

/// One round: edges split to the spacing, then at rest. False where too many points would be
/// needed.
bool refine(double spacing, const RimSheet& sheet, const PatchOptions& options, PatchMesh& disc) {
  check_stop(options.stop);
  const std::uint32_t before = disc.size() - disc.corners();
  if (before > options.max_new_points) return false;
  disc.split_long_edges(kLongestEdge * spacing, options.max_new_points + 1 - before, options.stop);
  if (disc.size() - disc.corners() > options.max_new_points) return false;
  disc.flip_to_delaunay();
  disc.smooth(sheet.triangles.empty() ? 1 : 2, sheet);
  disc.collapse_short_edges(kShortestEdge * spacing);
  disc.flip_to_delaunay();
  return true;
}

struct FairDisc {
  PatchMesh disc;
  double energy = 0.0;
};

/// A hole, and what its discs' energies are measured with: the vertices of the rim's faces alone,
/// in their order.
class DiscRim {
 public:
  DiscRim(const HoleProblem& hole, const Rim& its_rim) : problem(hole), rim(its_rim) {
    std::vector<std::uint32_t> used = problem.loop;
    for (const Triangle& t : rim.faces) used.insert(used.end(), t.begin(), t.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    const auto number_of = [&](std::uint32_t v) {
      return static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), v) -
                                        used.begin());
    };
    for (const std::uint32_t v : used) measured_.positions.push_back(problem.positions[v]);
    for (const std::uint32_t v : problem.loop) measured_.loop.push_back(number_of(v));
    for (const Triangle& t : rim.faces)
      faces_.push_back({number_of(t[0]), number_of(t[1]), number_of(t[2])});
  }

  double energy_of(const PatchMesh& disc) const {
    return bending_energy(measured_, faces_, shape_of_disc(measured_, rim, disc));
  }

  const HoleProblem& problem;
  const Rim& rim;

 private:
  HoleProblem measured_;
  std::vector<Triangle> faces_;
};

/// Rounds until the energy falls no more. A plate that has grown is another plate: its triangles,
/// by which it is measured, have too; on a ragged rim that need not come to an end. Without a
/// sheet it is a membrane. Empty where it would need too many points.
std::optional<FairDisc> fairest(const DiscRim& around, const RimSheet& sheet, double spacing,
                                PatchMesh disc, const PatchOptions& options) {
  constexpr int kRounds = 6;
  constexpr double kLeastGain = 0.97;  // energy of a round by that of the one before
  std::optional<FairDisc> best;
  for (int round = 0; round < kRounds; ++round) {
    if (!refine(spacing, sheet, options, disc)) return best;
    // Without points inside there is nothing to become fair.
    if (disc.size() == disc.corners()) return FairDisc{std::move(disc), 0.0};
    const double energy = around.energy_of(disc);
    if (best && !(energy < kLeastGain * best->energy)) break;
    best = {disc, energy};
  }
  return best;
}

/// As `fairest`, for discs of many points: fair with long edges, which are then halved again and
/// again, with a round each. The rounds of the finest disc, and with them its exact solutions, are
/// most of the work; they would change it little.
std::optional<FairDisc> fairest_by_levels(const DiscRim& around, const RimSheet& sheet,
                                          double spacing, double points, PatchMesh disc,
                                          const PatchOptions& options) {
  constexpr double kMany = 3000.0;  // a disc of fewer is solved for exactly
  int levels = 0;
  for (double fewer = points; fewer > kMany; fewer /= 4.0) ++levels;
  std::optional<FairDisc> fair =
      fairest(around, sheet, std::ldexp(spacing, levels), std::move(disc), options);
  if (!fair || levels == 0) return fair;
  while (levels > 0) {
    --levels;
    if (!refine(std::ldexp(spacing, levels), sheet, options, fair->disc)) return std::nullopt;
  }
  fair->energy = around.energy_of(fair->disc);
  return fair;
}

/// Which disc a plate starts from decides what it comes to: the fairer one of two, where it is
/// small enough for that and has more than a few points.
std::optional<FairDisc> fairest_plate(const DiscRim& around, const PatchMesh& start, double spacing,
                                      double points, const PatchOptions& options) {
  constexpr double kSmall = 300.0;  // on larger ones the other is no closer to what was cut out
  const RimSheet sheet = sheet_at_rim(around.problem, around.rim);
  std::optional<FairDisc> best = fairest_by_levels(around, sheet, spacing, points, start, options);
  constexpr std::uint32_t kFew = 3;
  if (points > kSmall) return best;
  if (best && best->disc.size() - best->disc.corners() <= kFew) return best;
  std::optional<FairDisc> other = fairest(around, {}, spacing, start, options);
  if (other) other = fairest(around, sheet, spacing, std::move(other->disc), options);
  return best && !(other && other->energy < best->energy) ? std::move(best) : std::move(other);
}

}  // namespace

std::string too_many_points(const PatchOptions& options) {
  return "needs more than " + std::to_string(options.max_new_points) + " new points";
}

std::optional<PatchMesh> smooth_disc(const HoleProblem& problem, const LoopTriangles& loop,
                                     int order, const PatchOptions& options) {
  const Rim& rim = loop.rim;
  const PatchMesh start = disc_of_loop(problem, loop);
  const double points = expected_points(start, rim.spacing);
  const double spacing = patch_spacing(rim, points, options);
  const double most = options.graded ? std::min(points, kMostPoints) : points;
  if (most > 1.5 * options.max_new_points + 16.0) return std::nullopt;
  const DiscRim around{problem, rim};
  std::optional<FairDisc> best = order < 2
                                     ? fairest_by_levels(around, {}, spacing, most, start, options)
                                     : fairest_plate(around, start, spacing, most, options);
  if (!best) return std::nullopt;
  return std::move(best->disc);
}

}  // namespace orbweave
