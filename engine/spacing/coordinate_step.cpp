#include "engine/spacing/coordinate_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

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

}  // namespace orbweave
