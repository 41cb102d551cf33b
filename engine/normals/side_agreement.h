// Whether normals that were given, or turned towards a scanner, fit the points and each other.
#pragma once

#include <cstdint>
#include <span>

#include "io/mesh_facts.h"
#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

struct SideCheck {
  std::uint32_t begin = 0, end = 0;  ///< the points to look at
  std::uint64_t first = 0;           ///< canonical number of point `begin`
  double reach = 0.0;                ///< neighbours are no farther away; world units
  /// One per point from `begin` on: 0 where it is not looked at.
  std::span<const std::uint8_t> asked;
  const StopToken* stop = nullptr;  ///< may be null
};

/// Looks at points of a cloud in canonical order. With all points within `reach` of those looked
/// at, the counts of the parts of a cloud add up to those of the whole.
SideFacts side_agreement(std::span<const Vec3> positions, std::span<const Vec3> normals,
                         const SideCheck& check);

}  // namespace orbweave
