// Points of a hole's plane on an integer grid, and the exact predicates on them.
#pragma once

#include <cstdint>

namespace orbweave {

/// A point of the hole's plane on an integer grid of at most kPlaneExtent either way, so that
/// orientation and in-circle tests are exact.
struct PlanePoint {
  std::int64_t x = 0;
  std::int64_t y = 0;
  friend bool operator==(const PlanePoint&, const PlanePoint&) = default;
};

/// Largest coordinate, either way. Predicates stay exact for points up to twice as far (the frame
/// in which triangulations are made): differences are below 2^30, so that products of two are
/// below 2^60 and those of four below 2^122.
inline constexpr std::int64_t kPlaneExtent = std::int64_t{1} << 28;

/// Twice the signed area, positive when a, b, c turn left; exact.
constexpr std::int64_t orientation(PlanePoint a, PlanePoint b, PlanePoint c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}
/// Positive when d is inside the circle of the counter-clockwise a, b, c, zero on it; exact.
int side_of_circle(PlanePoint a, PlanePoint b, PlanePoint c, PlanePoint d);

}  // namespace orbweave
