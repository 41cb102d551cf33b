// The fingerprint of a surface, computed while it streams by.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "io/triangle_mesh.h"

namespace orbweave {

/// XXH3-64 over: the vertices' coordinates (double, -0 as 0), their number (uint64), the
/// triangles' vertex indices (3 x uint64), their number (uint64), all little-endian. The counts
/// come last because a stream knows them last. All vertices are added before the first triangle
/// (std::logic_error otherwise); batches may have any size.
///
/// Callers add the vertices that triangles use, in file order, and number the triangles' corners
/// among those. The checksum thus depends on the surface alone: not on normals, attributes, file
/// format or stray points.
class MeshChecksum {
 public:
  MeshChecksum();
  ~MeshChecksum();
  MeshChecksum(MeshChecksum&&) noexcept;
  MeshChecksum& operator=(MeshChecksum&&) noexcept;

  void add_vertices(std::span<const Vec3> positions);
  void add_triangles(std::span<const Triangle64> triangles);
  /// 16 lower-case hexadecimal digits of what was added so far.
  std::string hex() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
