// Which coordinate reference system a LAS file says its coordinates are in.
#pragma once

#include <optional>
#include <string>

#include "io/clouds/las/las_variable_records.h"
#include "io/streams/random_access.h"
#include "io/vec3.h"

namespace orbweave::las {

/// WKT where the header asks for it or GeoTIFF keys name no code; else "EPSG:n" from the keys
/// (3072 of a projected system, else 2048 of a geographic one), with "+m" of a system of heights
/// (4096); else the keys' own words (citation); empty where the file says nothing of use.
/// LAS Specification 1.4 R15, section 3; OGC 19-008r4, GeoTIFF Standard 1.1, section 7.
std::string coordinate_system(const RandomAccess& file, const VariableRecords& records,
                              bool says_wkt);

/// Metres per unit of x, y and z in that system: the units of its WKT, else those of the GeoTIFF
/// keys (3076; 4099 of heights), else those of their codes; heights without a unit have that of x.
/// Empty where the file does not say, and for a system in degrees.
std::optional<Vec3> meters_per_unit(const RandomAccess& file, const VariableRecords& records,
                                    bool says_wkt);

}  // namespace orbweave::las
