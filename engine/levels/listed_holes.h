// The largest filled holes of a mesh that is read front to back.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "io/box.h"
#include "io/meshes/mesh_stream.h"

namespace orbweave {

struct ListedHole {
  std::int32_t hole = 0;
  float confidence = 1.0F;
  std::uint64_t triangles = 0;  ///< of the patch
  Box bounds;                   ///< of the patch
  Vec3 area;                    ///< its triangles' areas, each along its normal, added up
};

/// Keeps a fixed number of holes, whatever the size of the mesh. The triangles of a patch come one
/// after another in meshes of this program. Where they do not, a patch counts as several.
class ListedHoles {
 public:
  void add(const FacePatch& patch, const std::array<Vec3, 3>& corners);
  /// After the last triangle: the largest ones by the diagonals of their patches, then by their
  /// numbers.
  std::vector<ListedHole> largest();
  /// Of all patches, after largest().
  std::uint64_t count() const { return count_; }

 private:
  void keep_current();

  ListedHole current_;
  std::vector<ListedHole> kept_;
  std::uint64_t count_ = 0;
};

}  // namespace orbweave
