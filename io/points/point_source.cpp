#include "io/points/point_source.h"

#include <algorithm>

#include "io/points/coordinate_system.h"
#include "io/points/length_units.h"

namespace orbweave {

std::optional<Vec3> PointSource::meters_per_unit() const {
  const std::string system = coordinate_system();
  if (system.empty() || is_wkt(system)) return orbweave::meters_per_unit(system);
  const std::optional<CoordinateSystem> known = known_coordinate_system(system);
  return known ? known->meters_per_unit : std::nullopt;
}

std::vector<std::string> not_read(const FileFacts& facts) {
  std::vector<std::string> all = facts.lost_values;
  all.insert(all.end(), facts.left_out.begin(), facts.left_out.end());
  return all;
}

std::vector<ScannerPlace> scanner_places(const PointSource& source) {
  std::vector<ScannerPlace> places;
  for (const ScanFacts& scan : source.facts().scans)
    if (scan.scanner && scan.points > 0) places.push_back(*scan.scanner);
  if (const auto only = source.scanner(); only && places.empty()) places.push_back(*only);
  return places;
}

PointCloud read_all(PointSource& source) {
  constexpr std::size_t kBatchPoints = std::size_t{1} << 16;
  PointCloud cloud;
  cloud.schema = source.schema();
  // A count is believed only as far as the file could hold it: the narrowest point has 3 bytes.
  const std::uint64_t room = source.bytes_total() / 3;
  cloud.reserve(static_cast<std::size_t>(std::min(source.declared_points().value_or(0), room)));
  PointCloud batch;
  while (source.read(batch, kBatchPoints)) cloud.append(batch);
  return cloud;
}

}  // namespace orbweave
