// Coordinates of all magnitudes, as no scanner gives them: numbers that were read in the wrong byte
// order, or that are something else.
#pragma once

#include <span>
#include <string>

#include "engine/spacing/spacing_site.h"

namespace orbweave {

/// The magnitudes of points: of each its largest absolute coordinate, (0, 0, 0) apart.
struct CoordinateDecades {
  double least = 0.0;
  double most = 0.0;
  /// How many powers of ten hold nine tenths of the points. A scan has few, wherever its strays are
  /// and however close to zero some of its points lie.
  int crowded = 0;
};

/// O(n).
CoordinateDecades coordinate_decades(std::span<const SpacingSite> sites);

/// What is wrong with them: "coordinates span 76 decades, from 1e-38 to 1e+38: ..."; empty where
/// they are those of a scan.
std::string objection_to_decades(const CoordinateDecades& decades);

/// Throws Error (bad input) where there is an objection: the search for neighbours takes quadratic
/// time then. `file`: for the message.
void require_few_decades(std::span<const SpacingSite> sites, const std::string& file);

}  // namespace orbweave
