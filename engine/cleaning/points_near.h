// The part of a cloud that lies around some of its points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/vec3.h"

namespace orbweave {

/// All points within `reach` of one that is wanted, and some more; ascending. Quick for points in
/// canonical order.
std::vector<std::uint32_t> points_near(std::span<const Vec3> positions,
                                       std::span<const std::uint8_t> wanted, double reach);

/// A part of a cloud, in the same order, and where the points [begin, end) of the cloud are in it.
struct NearPart {
  std::vector<std::uint32_t> points;
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< empty without
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};
NearPart part_of(std::vector<std::uint32_t> points, std::span<const Vec3> positions,
                  std::span<const Vec3> normals, std::uint32_t begin, std::uint32_t end);

}  // namespace orbweave
