#include "engine/ball_pivoting/general_position.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "engine/ball_pivoting/halo_width.h"
#include "engine/ball_pivoting/perturbation.h"

namespace orbweave {
namespace {

constexpr int kStepsPerRadiusLog2 = 40;
constexpr int kStepsPerPerturbationLog2 = 20;
/// Whole numbers up to 2^53 are doubles.
constexpr int kExactStepsLog2 = 53;

/// Rounds to a whole number; ties go to the even one. The sum has no bits below one.
double to_whole(double value) {
  constexpr double kBitsBelowOneGone = 0x1.8p52;
  if (!(std::abs(value) < 0x1p51)) return std::nearbyint(value);
  return (value + kBitsBelowOneGone) - kBitsBelowOneGone;
}

}  // namespace

static_assert(kPerturbation >= 0x1p-20 && kStepsPerRadiusLog2 == 2 * kStepsPerPerturbationLog2,
              "the perturbation is at most kPerturbation of the smallest radius");

double lattice_step(std::span<const double> ball_radii) {
  const int fine = std::ilogb(ball_radii.front()) - kStepsPerRadiusLog2;
  // A point and its halo on both sides fit into exact coordinates.
  const int needed = std::ilogb(halo_width(ball_radii)) + 3 - kExactStepsLog2;
  return std::ldexp(1.0, std::max(fine, needed));
}

double largest_exact_extent(double step) { return std::ldexp(step, kExactStepsLog2); }

Vec3 on_lattice(Vec3 p, double step) {
  const double per_step = 1.0 / step;
  return {to_whole(p.x * per_step) * step, to_whole(p.y * per_step) * step,
          to_whole(p.z * per_step) * step};
}

std::vector<Vec3> general_position(std::span<const Vec3> positions, Vec3 origin, double step) {
  const double scale = std::ldexp(step, kStepsPerPerturbationLog2);
  std::vector<Vec3> local(positions.size());
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, positions.size(), 4096), [&](const Range& r) {
    for (std::size_t i = r.begin(); i < r.end(); ++i)
      local[i] = (on_lattice(positions[i], step) - origin) + perturbation(positions[i], scale);
  });
  return local;
}

}  // namespace orbweave
