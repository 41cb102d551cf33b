// A virtual range scanner: a shape as it is seen from several sides, with all that raw scans bring
// along. Each scan is what a scanner far away sees along parallel rays, a square grid of them: the
// nearest surface only, nothing at grazing angles, noise along the rays. The scans overlap and are
// slightly misregistered. They carry no normals.
//
// The same options give the same bits on every machine and for every batch size.
#pragma once

#include <memory>

#include "engine/synthetic/range_scans.h"
#include "engine/synthetic/synthetic_cloud.h"

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

/// In a scan's own frame the scanner looks along -z from far away, and the shape lies around the
/// origin. A scan that does not see the shape has no points.
class VirtualScanner : public RangeScans {
 public:
  /// Casts all rays once to count the points. Memory: O(rows of rays). Throws Error (usage) for
  /// options out of range and where no scan sees anything.
  explicit VirtualScanner(const VirtualScannerOptions& options);
  ~VirtualScanner() override;

  double ray_distance() const;  ///< between neighbouring rays, world units

 private:
  struct State;
  void cast_row(std::size_t scan, std::size_t row, Vec3* out) const override;

  std::unique_ptr<const State> state_;
};

}  // namespace orbweave
