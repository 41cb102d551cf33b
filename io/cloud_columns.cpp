#include "io/cloud_columns.h"

#include <string>

#include "io/error.h"

namespace orbweave {

void check_normal_count(std::size_t normals, std::size_t positions) {
  if (normals == 0 || normals == positions) return;
  throw_usage("there are not as many normals as positions",
              {.found = std::to_string(normals) + " normals for " + std::to_string(positions) +
                        " positions"});
}

void check_columns(const PointCloud& cloud) {
  check_normal_count(cloud.normals.size(), cloud.size());
  const std::size_t row_bytes = cloud.schema.attribute_bytes();
  if (cloud.attributes.size() == cloud.size() * row_bytes) return;
  throw_usage("the attributes are not those of the schema",
              {.found = std::to_string(cloud.attributes.size()) + " bytes",
               .expected = std::to_string(row_bytes) + " bytes for each of " +
                           std::to_string(cloud.size()) + " points"});
}

}  // namespace orbweave
