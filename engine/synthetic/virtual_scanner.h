// A virtual range scanner: a shape as it is seen from several sides, with all that raw scans bring
// along. Each scan is what a scanner far away sees along parallel rays, a square grid of them: the
// nearest surface only, nothing at grazing angles, noise along the rays. The scans overlap and are
// slightly misregistered. They carry no normals.
//
// The same options give the same bits on every machine and for every batch size.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/synthetic/synthetic_cloud.h"
#include "io/points/point_source.h"
#include "io/points/scan_pose.h"

namespace orbweave {

struct VirtualScannerOptions {
  /// The shape, about how many points all scans have together (within 2 % from 10,000 on), the
  /// seed and the precision. `noise`: standard deviation along the ray, in units of the distance
  /// between rays. `density_varying` has to be false.
  SyntheticOptions surface;
  /// Number of scans, 1 to 255. Up to 2, and 6: from +z, -z, +x, -x, +y, -y; otherwise directions
  /// spread evenly over the sphere. Each scanner is turned about its own direction at random.
  int scans = 6;
  /// Root mean square distance by which a scan's pose displaces its points, in units of the
  /// distance between rays; half of the mean square by a shift in a random direction, half by a
  /// turn about a random axis through the middle of the scan. >= 0.
  double misregistration = 0.0;
};

/// A scan's own frame: the scanner looks along -z from far away, the shape lies around the origin.
struct ScannerPose {
  /// x, y, z, w as a Stanford .conf has it: the conjugate turns scan coordinates to world ones.
  std::array<double, 4> quaternion = {0, 0, 0, 1};
  Vec3 translation;
  RigidMotion motion;  ///< the same; to world coordinates, misregistration included
};

class VirtualScanner {
 public:
  /// Casts all rays once to count the points. Memory: O(rows of rays). Throws Error (usage) for
  /// options out of range and where no scan sees anything.
  explicit VirtualScanner(const VirtualScannerOptions& options);
  ~VirtualScanner();

  int scans() const;
  double ray_distance() const;  ///< between neighbouring rays, world units
  std::uint64_t points() const;
  std::uint64_t points(int scan) const;  ///< zero where it does not see the shape
  const ScannerPose& pose(int scan) const;

  /// One scan in its own frame. The scanner has to outlive it. Uses the calling TBB arena.
  std::unique_ptr<PointSource> scan(int scan) const;
  /// All scans in world coordinates, one after the other, with a uint8 attribute `scan`: with
  /// float64 coordinates the same bits as pose(k).motion.point(p) of those of scan(k).
  std::unique_ptr<PointSource> all() const;

  struct State;

 private:
  std::unique_ptr<const State> state_;
};

}  // namespace orbweave
