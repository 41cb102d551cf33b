// Which patch a ray from another patch meets first.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <unordered_map>
#include <vector>

#include "engine/normals/cell_blocks.h"
#include "engine/normals/patch_sums.h"
#include "io/vec3.h"

namespace orbweave {

/// Patches as pieces of planes: through the mean of their points, perpendicular to their area
/// vector, as large as their bounds and one and a half distances of their points around them.
class PatchRays {
 public:
  static constexpr std::uint32_t kNothing = std::numeric_limits<std::uint32_t>::max();

  struct Hit {
    std::uint32_t patch = kNothing;
    double distance = 0.0;  ///< to the hit, or to where the ray leaves the patches' bounds
  };

  /// `cell`: side of the patches' lattice. `turn`: of patches, on top of their sums; empty: none.
  /// `part`: that a patch belongs to; empty: all to one. Sums and parts must outlive this.
  PatchRays(std::span<const PatchSum> sums, double cell, std::span<const std::uint8_t> turn,
            std::span<const std::uint32_t> part);

  /// A point of the patch's plane in the middle of its bounds.
  Vec3 middle(std::uint32_t patch) const;
  /// As turned. Zero for a patch without an area vector, which no ray meets and which sends none.
  Vec3 normal(std::uint32_t patch) const { return planes_[patch].normal; }
  /// The first patch in a direction (a unit vector) from the middle of another. What lies nearer
  /// than the points of the patch lie to each other does not count: it may be the same layer. Nor
  /// does a patch of the same part beside this one that faces about as this one does and is met
  /// from the same side: on a curved surface the plane of a neighbour reaches over this one.
  /// Precondition: the other has a normal.
  Hit first(std::uint32_t from, Vec3 direction) const;

 private:
  struct Plane {
    Vec3 normal;
    double offset = 0.0;   // of the plane, from the corner of the patch's cell along the normal
    double spacing = 0.0;  // mean distance of its points
  };
  using Place = LatticePlace;
  class Walk;

  Place cell_of(Vec3 position) const;
  /// Counted from the lowest cells that hold patches.
  Place counted(const Place& place) const;
  double distance_to(std::uint32_t patch, Vec3 origin, Vec3 direction) const;
  bool is_beside(std::uint32_t from, std::uint32_t patch) const;
  bool is_same_layer(std::uint32_t from, std::uint32_t patch, Vec3 direction) const;

  std::span<const PatchSum> sums_;
  std::span<const std::uint32_t> part_;
  double cell_;
  std::vector<Plane> planes_;
  Place lowest_{}, highest_{};  // cells that hold patches
  std::vector<std::uint32_t> by_cell_;
  // By counted cells; only looked up: the order of entries does not matter.
  std::unordered_map<Place, std::pair<std::uint32_t, std::uint32_t>, LatticePlaceHash>
      rows_of_cell_;
  CellBlocks blocks_{{}};
};

}  // namespace orbweave
