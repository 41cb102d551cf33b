// The surface of genus 3 behind `generate genus-3`: a round plate with three round holes, whose
// rims are round as well, so that the surface has one tangent plane everywhere.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/synthetic/row.h"
#include "engine/synthetic/surfaces.h"

namespace orbweave::synthetic {

inline constexpr int kPlateHoles = 3;
inline constexpr double kPlateRadius = 1.3;         ///< of the flat sides
inline constexpr double kPlateHoleRadius = 0.4;     ///< of the holes in the flat sides
inline constexpr double kPlateHoleDistance = 0.65;  ///< of their centres from the plate's
inline constexpr double kPlateHalf = 0.2;           ///< half the thickness, and radius of the rims

/// Where the parts of the plate are, as sheets of rows.
enum PlateSheet : int { kPlateTop, kPlateBottom, kPlateRim, kPlateFirstHole };

Vec3 plate_hole_center(int hole);
double plate_area();

/// Of a flat side: x and y. Of a rim: u the angle around it, v that around its tube, a quarter at
/// the upper side.
SurfacePoint plate_side_point(PlateSheet sheet, double x, double y);
SurfacePoint plate_rim_point(int sheet, portable::SineCosine u, portable::SineCosine v);

/// Distance from the flat middle of the plate less half the thickness: zero on the surface, the
/// distance from it outside.
TubeField plate_field(Vec3 position);

/// Near-uniform rows, in all `points` points. Varying: the density is 1 where the holes are
/// narrowest, 4 on the flat sides and 16 where the plate is widest.
std::vector<Row> plate_rows(std::uint64_t points, bool density_varying);

}  // namespace orbweave::synthetic
