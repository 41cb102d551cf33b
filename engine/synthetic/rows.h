// Near-uniform points on a surface, as rows: rows lie sqrt(3)/2 of the local spacing apart, the
// points of a row 2/sqrt(3) of it, neighbouring rows are shifted. Whatever the shift, the largest
// empty circle between two rows has a radius of at most 0.73 spacings and no two points are closer
// than 0.86, so that row lengths and counts are free to follow the surface and the density.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/synthetic/row.h"
#include "engine/synthetic/synthetic_options.h"

namespace orbweave::synthetic {

/// How many of the points, the first ones, lie on a sphere, which has no rows.
std::uint64_t sphere_points(const SyntheticOptions& options);

/// Rows of the points that are not on a sphere; their counts sum to the number of these. No row is
/// empty.
/// Sheets: 0 (tori, plane); 0 and 1 (double wall: bottom, top); of the cube 0 to 5 the faces
/// x=0, x=1, y=0, ... and 6 to 17 the edges (6 + 4 axis + position); of genus 3: PlateSheet.
std::vector<Row> rows_of(const SyntheticOptions& options);

/// Square root of the relative density, 1 + 3 t when varying, its integral and the inverse of
/// that; t in [0, 1].
struct DensityProfile {
  bool varying = false;
  double root_density(double t) const;
  double integral(double t) const;
  double inverse_integral(double value) const;
};

}  // namespace orbweave::synthetic
