#include "engine/spacing/orientation_cell.h"

#include <cmath>

namespace orbweave {
namespace {

constexpr double kCellPerSpacing = 12.0;

/// The least power of two that is not below; the same on every machine, as logarithms are not.
double power_of_two_above(double value) {
  int exponent = 0;
  const double mantissa = std::frexp(value, &exponent);
  return std::ldexp(1.0, mantissa == 0.5 ? exponent - 1 : exponent);
}

}  // namespace

double orientation_cell(double spacing) { return power_of_two_above(kCellPerSpacing * spacing); }

}  // namespace orbweave
