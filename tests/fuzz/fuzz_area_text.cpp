// Any bytes as WKT or GeoJSON of polygons. An area holds its corners.
#include "io/points/area_text.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "io/error.h"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

/// A hole may be anywhere, so corners of outer rings are tested without holes.
void check_corners(std::vector<orbweave::AreaPolygon> polygons) {
  for (orbweave::AreaPolygon& polygon : polygons) polygon.holes.clear();
  const orbweave::PolygonArea area(polygons);
  for (const orbweave::AreaPolygon& polygon : polygons)
    for (const orbweave::AreaPoint& corner : polygon.outer)
      require(area.contains(corner[0], corner[1]));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  orbweave::is_area_text(text);
  try {
    const std::vector<orbweave::AreaPolygon> polygons = orbweave::parse_area(text, "input");
    require(!polygons.empty());
    const orbweave::PolygonArea area(polygons);
    area.contains(0.0, 0.0);
    check_corners(polygons);
  } catch (const orbweave::Error& error) {
    require(error.kind() == orbweave::ErrorKind::kBadInput);
  }
  return 0;
}
