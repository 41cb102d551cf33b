// The part of a cloud that lies around some of its points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/lattice_cube.h"
#include "io/vec3.h"

namespace orbweave {

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

/// Runs of points in one cube of a lattice: few and long for points in canonical order. Made once,
/// asked for several parts.
class PointRuns {
 public:
  /// Parts whose reach is several times `side` or less are found quickly.
  PointRuns(std::span<const Vec3> positions, double side);

  /// All points within `reach` of one that is wanted, and some more; ascending. All where most are
  /// wanted.
  std::vector<std::uint32_t> near(std::span<const std::uint8_t> wanted, double reach) const;

 private:
  struct Run {
    LatticeCell cube;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
  };
  /// Of the runs, in a lattice that is `step` times as coarse.
  std::vector<LatticeCell> coarse_cubes(std::int64_t step) const;

  double side_;
  std::vector<Run> runs_;
};

}  // namespace orbweave
