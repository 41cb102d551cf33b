// Lengths of the units of coordinate systems.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "io/vec3.h"

namespace orbweave {

/// Metres per unit of x, y and z in a coordinate system given as WKT, version 1 or 2: the unit of a
/// projected or local system, and for z that of a vertical one beside it. Empty for anything else:
/// degrees have no length, and what is no WKT has no unit.
/// OGC 01-009, Coordinate Transformation Services, section 7; OGC 18-010r7, WKT of Coordinate
/// Reference Systems, section 7.4.
std::optional<Vec3> meters_per_unit(std::string_view wkt);

/// Metres per unit of an EPSG code of a unit of length (9001 metre, 9002 foot, 9003 US survey foot,
/// 9036 kilometre). Empty for all others.
std::optional<double> meters_per_epsg_unit(std::uint16_t code);

/// Metres per unit of x, y and z: as the user says, or else as the scan does. Empty: not known.
std::optional<Vec3> meters_per_unit(std::optional<double> units_per_meter,
                                    std::optional<Vec3> of_scan);

}  // namespace orbweave
