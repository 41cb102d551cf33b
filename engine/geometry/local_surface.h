// The surface around a point: a weighted plane and a quadratic height field over it.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "io/vec3.h"

namespace orbweave {

struct SurfaceSample {
  Vec3 offset;  ///< from the point in question, in units of the neighbourhood's radius
  double weight = 1.0;
};

/// height(x, y) = c[0] + c[1] x + c[2] y + c[3] x^2 + c[4] xy + c[5] y^2 over the plane through the
/// point in question, spanned by u and v.
struct LocalSurface {
  Vec3 u, v, normal;
  std::array<double, 6> c{};
  bool is_quadratic = false;  ///< false: a plane, c[1] to c[5] are 0

  /// How far an offset lies above the surface, along the plane's normal.
  double distance_above(Vec3 offset) const;
  /// Foot of the point in question, and the unit normal of the surface there.
  Vec3 foot() const { return c[0] * normal; }
  Vec3 normal_at_foot() const { return normalized(normal - c[1] * u - c[2] * v); }
};

/// Least squares, summed in the order of the samples. A plane where twelve samples or their spread
/// do not suffice for more; nothing where they are fewer than three or lie on a line. `normal` is
/// on the side of `side`. Additions, multiplications, divisions and roots alone: the same bits on
/// every machine that runs the same build (a build for other vector instructions may add up the
/// factors of the quadric in another order).
std::optional<LocalSurface> fit_surface(std::span<const SurfaceSample> samples, Vec3 side);

}  // namespace orbweave
