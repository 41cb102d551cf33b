// Triangles that no surface consists of, for meshes from elsewhere.
#pragma once

#include <cstdint>

#include "io/triangle_mesh.h"

namespace orbweave {

/// Triangles that were taken out of a mesh.
struct UnusableTriangles {
  std::uint64_t degenerate = 0;  ///< two equal vertices
  std::uint64_t repeated = 0;    ///< the vertices of an earlier one, however oriented
  std::uint64_t not_finite = 0;  ///< a coordinate that is no finite number
  std::uint64_t all() const { return degenerate + repeated + not_finite; }
};

/// Takes them out; the others keep their order, the vertices stay as they are. Indices must be in
/// range. O(n log n), 16 bytes per triangle.
UnusableTriangles remove_unusable_triangles(TriangleMesh& mesh);

}  // namespace orbweave
