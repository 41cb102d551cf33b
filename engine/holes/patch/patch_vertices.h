// New vertices of patches as points with the attributes of the cloud.
#pragma once

#include <cstdint>
#include <span>

#include "io/point_cloud.h"

namespace orbweave {

/// Points of `schema` from positions, unit normals and interpolated attribute values (points x
/// attributes; whole numbers are rounded, and everything kept within its type's range).
PointCloud patch_vertices(const PointSchema& schema, std::span<const Vec3> positions,
                          std::span<const Vec3> normals, std::span<const double> values);

/// Attributes of points as doubles: points x attributes.
std::vector<double> attribute_values(const PointCloud& cloud, std::span<const std::uint64_t> rows);

}  // namespace orbweave
