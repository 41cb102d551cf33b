#include "engine/spacing/coordinate_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "engine/spacing/site_points.h"

namespace orbweave {
namespace {

bool is_float(double value) {
  return std::abs(value) <= std::numeric_limits<float>::max() &&
         static_cast<double>(static_cast<float>(value)) == value;
}

/// By Euclid; exact for numbers of few digits.
double common_divisor(double a, double b) {
  while (b > 0.0) a = std::exchange(b, std::fmod(a, b));
  return a;
}

/// The largest absolute coordinate; negative where some are no floats.
double largest_float(std::span<const SpacingSite> sites, int axis) {
  double largest = 0.0;
  for (const SpacingSite& site : sites)
    for (const Vec3& p : site.points) {
      if (!is_float(p[axis])) return -1.0;
      largest = std::max(largest, std::abs(p[axis]));
    }
  return largest;
}

/// Whether coordinates differ by no more than `step` and its multiples.
bool comes_in_steps(std::span<const SpacingSite> sites, int axis, double step) {
  double divisor = 0.0;
  std::optional<double> first;
  for (const SpacingSite& site : sites)
    for (const Vec3& p : site.points) {
      if (!first) first = p[axis];
      divisor = common_divisor(std::abs(p[axis] - *first), divisor);
      if (divisor > 0.0 && divisor <= step) return true;
    }
  return false;
}

double step_along(std::span<const SpacingSite> sites, int axis) {
  const double largest = largest_float(sites, axis);
  if (!(largest > 0.0)) return 0.0;
  const double step =
      std::ldexp(1.0, std::ilogb(largest) - (std::numeric_limits<float>::digits - 1));
  return comes_in_steps(sites, axis, step) ? step : 0.0;
}

/// Values of one axis in their order; of large sites every so many.
std::vector<double> sorted_values(std::span<const SpacingSite> sites, int axis) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 18;
  const std::uint64_t stride = 1 + points_of(sites) / kMost;
  std::vector<double> values;
  for (const SpacingSite& site : sites)
    for (std::size_t i = 0; i < site.points.size(); i += stride)
      values.push_back(site.points[i][axis]);
  std::ranges::sort(values);
  return values;
}

/// Up to what an exact multiple of a step may be off: two places of the largest value, of floats
/// where all values are floats.
double rounding_of(const std::vector<double>& sorted) {
  const double largest = std::max(std::abs(sorted.front()), std::abs(sorted.back()));
  if (!(largest > 0.0)) return 0.0;
  const int digits = std::ranges::all_of(sorted, is_float) ? std::numeric_limits<float>::digits
                                                           : std::numeric_limits<double>::digits;
  return std::ldexp(1.0, std::ilogb(largest) - digits + 2);
}

/// The step of one axis, by Euclid's algorithm on the gaps between neighbouring values. The gaps
/// come in their order, and far jumps are left out, so that rounding stays small beside the step.
double common_step_along(std::span<const SpacingSite> sites, int axis) {
  constexpr double kFarthest = 16.0;      // gaps of more steps tell nothing
  constexpr double kOff = 0.1;            // of a step
  constexpr std::size_t kFewestGaps = 8;  // fewer may agree by chance
  const std::vector<double> values = sorted_values(sites, axis);
  if (values.empty()) return 0.0;
  const double rounding = rounding_of(values);
  std::vector<double> gaps;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (const double gap = values[i] - values[i - 1]; gap > rounding) gaps.push_back(gap);
  if (gaps.size() < kFewestGaps) return 0.0;
  std::ranges::sort(gaps);
  double step = gaps.front();
  const double finest = kFarthest * rounding / kOff;
  for (const double gap : gaps) {
    if (step < finest) return 0.0;
    if (gap > kFarthest * step) break;
    const double rest = std::abs(gap - std::round(gap / step) * step);
    if (rest > kOff * step) step = rest;
  }
  if (step < finest || gaps[kFewestGaps - 1] > kFarthest * step) return 0.0;
  double lengths = 0.0, steps = 0.0;  // their quotient has less of the rounding than one gap
  for (const double gap : gaps) {
    if (gap > kFarthest * step) break;
    lengths += gap;
    steps += std::round(gap / step);
  }
  return lengths / steps;
}

}  // namespace

double coordinate_step(std::span<const SpacingSite> sites) {
  return std::max({step_along(sites, 0), step_along(sites, 1), step_along(sites, 2)});
}

std::string objection_to_step(double step, double spacing) {
  constexpr double kMostOfSpacing = 0.1;
  if (!(spacing > 0.0) || step <= kMostOfSpacing * spacing) return {};
  return "coordinates come in steps of about " + short_text(step) + ", the points lie " +
         short_text(spacing) + " apart: export them as doubles, or with an offset";
}

double common_step(std::span<const SpacingSite> sites) {
  double least = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    least = std::min(least, common_step_along(sites, axis));
    if (least == 0.0) break;
  }
  return least;
}

std::string objection_to_common_step(double step, double spacing) {
  if (!(spacing > 0.0) || spacing >= spacing_for_step(step)) return {};
  return "coordinates on all axes come in steps of " + short_text(step) + ", the points lie " +
         short_text(spacing) +
         " apart, so that the mesh is rough and may have holes: export them in finer steps (more "
         "decimals, a smaller scale of LAS)";
}

double spacing_for_step(double common_step) {
  // Clean scans that are rounded to a tenth or a fifth of their spacing keep their surface; from a
  // quarter on, balls pass over points and holes open.
  constexpr double kStepsPerSpacing = 5.0;
  return kStepsPerSpacing * common_step;
}

}  // namespace orbweave
