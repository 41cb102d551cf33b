#include "io/keep_points.h"

#include <cstring>

namespace orbweave {

void keep_points(std::span<const std::uint8_t> kept, PointCloud& cloud) {
  const std::size_t bytes = cloud.schema.attribute_bytes();
  std::size_t end = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (kept[i] == 0) continue;
    if (end != i) {
      cloud.positions[end] = cloud.positions[i];
      if (!cloud.normals.empty()) cloud.normals[end] = cloud.normals[i];
      if (bytes != 0)
        std::memcpy(cloud.attributes.data() + end * bytes, cloud.attributes.data() + i * bytes,
                    bytes);
    }
    ++end;
  }
  cloud.positions.resize(end);
  if (!cloud.normals.empty()) cloud.normals.resize(end);
  cloud.attributes.resize(end * bytes);
}

}  // namespace orbweave
