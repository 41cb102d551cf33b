// Neighbours that lie nearly on a line tell no plane: more of them are asked for.
#pragma once

#include <cstddef>

#include "engine/geometry/symmetric_eigen.h"

namespace orbweave {

/// Variance across a row of points over that along it, below which more neighbours are asked for:
/// deviations of 1:10.
inline constexpr double kNearlyALine = 1e-2;
/// A row that is nothing but a row at this many times the neighbours asked for stays one.
inline constexpr std::size_t kMostEnlarged = 16;

/// Whether points of that spread lie nearly on a line, or in one place.
inline bool nearly_a_line(const SymmetricEigen& spread) {
  return !(spread.values[1] > kNearlyALine * spread.values[2]);
}

}  // namespace orbweave
