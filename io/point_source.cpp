#include "io/point_source.h"

#include <algorithm>

#include "io/byte_source.h"
#include "io/ply_source.h"

namespace orbweave {

std::unique_ptr<PointSource> open_point_source(const std::filesystem::path& path,
                                               const PointSourceOptions& options) {
  (void)options;
  return open_ply_source(open_byte_source(path));
}

PointCloud read_all(PointSource& source) {
  constexpr std::size_t kBatchPoints = std::size_t{1} << 16;
  PointCloud cloud;
  cloud.schema = source.schema();
  // A count is believed only as far as the file could hold it: a point takes six bytes of text
  // or three of the narrowest binary.
  const std::uint64_t room = source.bytes_total() / 3;
  cloud.reserve(static_cast<std::size_t>(std::min(source.declared_points().value_or(0), room)));
  PointCloud batch;
  while (source.read(batch, kBatchPoints)) cloud.append(batch);
  return cloud;
}

}  // namespace orbweave
