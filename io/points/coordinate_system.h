// What PROJ knows of the coordinate systems that scans name. PROJ is used here and nowhere else.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "io/box.h"
#include "io/vec3.h"

namespace orbweave {

/// A coordinate system as PROJ understands it.
struct CoordinateSystem {
  std::string name;            ///< "NAD83 / UTM zone 12N"
  std::string code;            ///< "EPSG:26912"; empty: it has none
  std::string wkt;             ///< as given, or what its code stands for
  bool is_geographic = false;  ///< x and y are degrees
  /// Metres per unit of x, y and z; heights without a unit of their own have that of x. Empty:
  /// degrees have no length.
  std::optional<Vec3> meters_per_unit;
};

/// Whether PROJ finds its database, which holds all codes and the areas where systems are used.
bool has_coordinate_database();

/// Whether a text begins as WKT does: a keyword and an opening bracket.
bool is_wkt(const std::string& text);

/// The system that a text stands for: WKT of any version, "EPSG:26912", "EPSG:26912+5703".
/// Empty where PROJ makes nothing of it.
std::optional<CoordinateSystem> known_coordinate_system(const std::string& text);

/// The system that a user's text means, as known_coordinate_system() takes it: WKT and codes of
/// EPSG (in any case) as they are, and what else PROJ understands (PROJ strings, URNs, other
/// authorities' codes, names) as a code of EPSG or WKT. Empty where PROJ makes nothing of it.
std::string system_of_text(const std::string& text);

/// The system in a few words for messages: name and code; the beginning of what PROJ does not know.
std::string words_of_system(const std::string& text);

/// Columns of a matrix, four numbers each: from coordinates about `origin` to the Earth-centred,
/// Earth-fixed metres of WGS 84 (EPSG:4978). Linear about the origin: at 10 km from it a projected
/// system is off by some metres, mostly in height. Heights are
/// taken for heights above the ellipsoid: those above a geoid lie up to 100 m beside that. Empty
/// for degrees and for what PROJ cannot transform.
std::optional<std::array<double, 16>> earth_from_local(const std::string& system, Vec3 origin);

enum class SystemsDiffer { kNo, kYes, kUnknown };
/// Whether coordinates of one system are wrong in the other. A system that says nothing of heights
/// fits every system of heights. kUnknown: the texts differ, and PROJ does not understand both.
SystemsDiffer systems_differ(const std::string& a, const std::string& b);

/// Why coordinates within these bounds can hardly be of this system: what their centre would be.
/// Empty where nothing speaks against them, or where PROJ cannot tell.
std::string objection_to_coordinates(const std::string& system, const Box& bounds);

}  // namespace orbweave
