// The plane of a hole.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/holes/patch/rim.h"
#include "engine/holes/problem/hole.h"
#include "engine/holes/triangulation/plane_point.h"

namespace orbweave {

/// Right-handed, orthonormal, with its origin in the rim's centre. The axis points to where the
/// sheet's normals do.
struct HoleFrame {
  Vec3 u;
  Vec3 v;
  Vec3 axis;

  /// From a place relative to the rim's centre to plane coordinates and a height, and back.
  Vec3 to_frame(Vec3 x) const { return {dot(x, u), dot(x, v), dot(x, axis)}; }
  Vec3 to_space(Vec3 x) const { return x.x * u + x.y * v + x.z * axis; }
};

/// The least cosine between a normal and the axis in a height field: 75 degrees. Beyond it heights
/// change so fast from point to point that an interpolant of them swings.
inline constexpr double kLeastUpright = 0.2588190451025207;

struct FrameChoice {
  std::optional<HoleFrame> frame;
  std::string reason;  ///< why there is none
};

/// The frame about the axis along which the rim's faces are most upright, where the rim is a simple
/// polygon in it, counter-clockwise. Else the most upright one with a simple rim of four: about the
/// faces' mean normal, the loop's area vector, the direction between these, and the principal axis
/// of the sheet around (as in the paper). Measured on discs cut from scans, the first is at least
/// as close to what was there as any.
FrameChoice choose_frame(const HoleProblem& problem, const Rim& rim);

/// Plane coordinates on the integer grid. `radius`: of what has to fit, about the origin.
std::vector<PlanePoint> snap_to_grid(std::span<const Vec3> places, double radius);

}  // namespace orbweave
