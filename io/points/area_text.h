// Polygons from text: WKT (OGC 06-103r4, Simple Features) and GeoJSON (RFC 7946).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/points/polygon_area.h"

namespace orbweave {

/// Longest text that is taken. What it becomes in memory is a fraction of the least budget of a
/// job.
inline constexpr std::size_t kMostAreaBytes = std::size_t{4} << 20;
/// Most corners of all rings together; with its index, a corner takes some hundred bytes.
inline constexpr std::size_t kMostAreaCorners = std::size_t{1} << 17;

/// Whether a text is WKT itself, and not the path of a file: it begins with POLYGON or MULTIPOLYGON
/// in any case, maybe behind "SRID=...;", with a blank or a bracket behind.
bool is_area_text(std::string_view text);

/// The polygons of a text: GeoJSON where it begins with '{', else WKT. WKT is one or more of
/// POLYGON and MULTIPOLYGON, each maybe behind "SRID=...;". GeoJSON is a Polygon, a MultiPolygon,
/// or a Feature, a collection of features or of geometries that holds nothing else. Coordinates
/// beyond x and y are passed over. `name` is for messages. Throws Error (bad input) with the place.
std::vector<AreaPolygon> parse_area(std::string_view text, const std::string& name);

/// The polygons of a file.
std::vector<AreaPolygon> read_area(const std::filesystem::path& path);

}  // namespace orbweave
