// Poses of virtual scanners, and errors of such poses.
#pragma once

#include <array>
#include <cstdint>

#include "io/points/scan_pose.h"
#include "io/vec3.h"

namespace orbweave {

/// From a scan's own frame to the world's.
struct ScannerPose {
  /// x, y, z, w as a Stanford .conf has it: the conjugate turns scan coordinates to world ones.
  std::array<double, 4> quaternion = {0, 0, 0, 1};
  Vec3 translation;
  RigidMotion motion;  ///< the same; to world coordinates, misregistration included
};

namespace synthetic {

using Quaternion = std::array<double, 4>;  ///< x, y, z, w; turns p into q p q*

/// a after b.
Quaternion product(const Quaternion& a, const Quaternion& b);

/// The turn by `turns` full circles around the z axis.
Quaternion turn_around_z(double turns);

/// Number, sum and squares of points: what the error of a pose is scaled by.
struct PointMoments {
  double points = 0.0;
  Vec3 sum;
  std::array<Vec3, 3> products;  ///< sum of p p^T

  void add(Vec3 p);
  void add(const PointMoments& other);
  Vec3 mean() const { return sum / points; }
  /// Mean of |axis x (p - mean)|^2.
  double leverage(Vec3 axis) const;
};

/// The pose of `rotation` and `translation`, then a shift and a turn that displace the points of
/// `moments`, in world coordinates, by their root mean square, by `displacement`; half of the mean
/// square each. `index`: another one, other random directions.
ScannerPose misregistered(const Quaternion& rotation, Vec3 translation, const PointMoments& moments,
                          double displacement, std::uint64_t seed, std::uint64_t index);

}  // namespace synthetic
}  // namespace orbweave
