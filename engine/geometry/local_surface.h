// The surface around a point: a weighted plane and a quadratic height field over it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry/surface_kernel.h"
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
  /// Unit normal of the surface above or below an offset.
  Vec3 normal_at(Vec3 offset) const;
};

/// Owns columns of points near a place.
class NearPoints {
 public:
  /// Room for `capacity` points; invalidates the columns.
  void reserve(std::size_t capacity);
  NearColumns columns;

 private:
  std::vector<double> values_;
  std::size_t capacity_ = 0;
};

/// Samples of one surface. Those of zero weight are none.
struct SurfaceSamples {
  const NearColumns* near = nullptr;
  std::uint32_t count = 0;  ///< with a weight
  Vec3 side;                ///< the surface's normal is on this side
};

/// As many surfaces as are fitted in about the time of one.
inline constexpr std::size_t kSurfacesAtOnce = 4;

/// Least squares. A plane where twelve samples or their spread do not suffice for more; nothing
/// where they are fewer than three or lie on a line. Sums are of four partial sums, sample i in the
/// (i mod 4)th. The same bits on every machine, and whatever other surfaces are fitted at the same
/// time. At most kSurfacesAtOnce of them.
void fit_surfaces(std::span<const SurfaceSamples> samples,
                  std::span<std::optional<LocalSurface>> surfaces);
std::optional<LocalSurface> fit_surface(std::span<const SurfaceSample> samples, Vec3 side);

}  // namespace orbweave
