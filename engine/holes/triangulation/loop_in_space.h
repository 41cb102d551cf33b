// A loop in space that is to be triangulated without new points.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "io/vec3.h"

namespace orbweave {

struct LoopInSpace {
  std::span<const Vec3> corners;            ///< positions along the loop
  std::span<const std::uint32_t> vertices;  ///< which mesh vertex each corner is
  /// Unit normal of the face behind edge (i, i + 1), zero where unknown; or empty.
  std::span<const Vec3> rim_normals;
  std::span<const std::array<std::uint32_t, 2>> forbidden;  ///< mesh vertices, sorted
  /// (mesh vertex, group), sorted: vertices of one group are not joined.
  std::span<const std::array<std::uint32_t, 2>> apart = {};
};

/// Up to so many corners the largest dihedral angle is the least of all triangulations.
inline constexpr std::uint32_t kLeastBendCorners = 24;

}  // namespace orbweave
