// The largest filled holes of a mesh that is read front to back.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
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

/// Holds every hole, in some 150 bytes: the triangles of a patch may come in any order, as those of
/// simplified meshes do.
class ListedHoles {
 public:
  void add(const FacePatch& patch, const std::array<Vec3, 3>& corners);
  /// The largest ones by the diagonals of their patches, then by their numbers.
  std::vector<ListedHole> largest() const;
  std::uint64_t count() const { return holes_.size(); }

 private:
  std::unordered_map<std::int32_t, ListedHole> holes_;
  ListedHole* last_ = nullptr;  ///< of the last triangle: most patches come one after another
};

}  // namespace orbweave
