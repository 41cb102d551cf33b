// What the faces of levels of detail carry: the hole that they fill, and their component.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

struct FaceTag {
  std::int32_t hole = 0;        ///< the hole's id; 0: scanned surface
  float confidence = 1.0F;      ///< of the patch; 1: scanned surface, or not known
  std::uint32_t component = 0;  ///< rank of the component in the whole mesh, the largest first
  friend auto operator<=>(const FaceTag&, const FaceTag&) = default;
};

/// Tags of the triangles that a simplification left, over the vertices that the surface had before.
/// An edge collapse moves corners of triangles, so a triangle has the tag of that one of the
/// triangles around its corners before that is nearest to its middle, among equally near ones that
/// of the lowest number. A component stays what it is. Empty where `tags` is.
std::vector<FaceTag> simplified_tags(std::span<const Vec3> positions,
                                     std::span<const Triangle> before,
                                     std::span<const FaceTag> tags,
                                     std::span<const Triangle> after);

}  // namespace orbweave
