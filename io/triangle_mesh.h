// What a triangle mesh is, in core. Meshes of any size are streamed through MeshWriter instead.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave {

/// Three vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;
/// Indices into a mesh of any size.
using Triangle64 = std::array<std::uint64_t, 3>;

/// A mesh in core. `vertices` carries positions, normals and attributes.
/// `hole` is empty or holds one id per triangle (0: scanned surface).
/// A plain value: many threads may read it, none while another one changes it.
struct TriangleMesh {
  PointCloud vertices;
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> hole;
};

/// The triangle rotated so that its smallest index comes first; orientation is kept.
template <class Index>
constexpr std::array<Index, 3> smallest_first(std::array<Index, 3> t) {
  if (t[1] < t[0] && t[1] < t[2]) return {t[1], t[2], t[0]};
  if (t[2] < t[0] && t[2] < t[1]) return {t[2], t[0], t[1]};
  return t;
}

}  // namespace orbweave
